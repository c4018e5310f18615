#include "base/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

static const char *log_program = "garland";
static log_level_t log_level = LOG_WARN;

void log_open(const char *program, log_level_t level)
{
    log_program = program;
    log_level = level;
}

__attribute__((format(printf, 2, 0))) static void log_line(log_level_t level, const char *format, va_list args)
{
    if (level > log_level)
        return;
    char line[2048];
    int used = snprintf(line, sizeof line, "%s: ", log_program);
    const int text = vsnprintf(line + used, sizeof line - (size_t)used - 1, format, args);
    used += text < 0 ? 0 : text;
    if (used > (int)sizeof line - 2)
        used = (int)sizeof line - 2;
    line[used++] = '\n';
    const ssize_t written = write(STDERR_FILENO, line, (size_t)used);
    (void)written; /* a log that cannot be written has nowhere to complain */
}

void log_warn(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    log_line(LOG_WARN, format, args);
    va_end(args);
}

void log_info(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    log_line(LOG_INFO, format, args);
    va_end(args);
}

void log_debug(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    log_line(LOG_DEBUG, format, args);
    va_end(args);
}
