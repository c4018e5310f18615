/* log.h: lines on standard error: "garland-worker: text". Thread-safe; one write per line.
 * Messages are for people; nothing parses them. */
#ifndef BASE_LOG_H
#define BASE_LOG_H

typedef enum log_level { LOG_QUIET = 0, LOG_WARN = 1, LOG_INFO = 2, LOG_DEBUG = 3 } log_level_t;

void log_open(const char *program, log_level_t level); /* program is borrowed for the process's life */
void log_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));
void log_info(const char *format, ...) __attribute__((format(printf, 1, 2)));
void log_debug(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
