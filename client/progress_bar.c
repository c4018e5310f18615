#include "client/progress_bar.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"

enum { BAR_WIDTH = 24, LINE_SIZE = 256 };

static const double terminal_interval = 0.2, line_interval = 5, smoothing_seconds = 3;

void progress_bar_begin(progress_bar_t *bar, bool quiet)
{
    *bar = (progress_bar_t){.terminal = isatty(STDERR_FILENO) != 0, .quiet = quiet};
}

void progress_bar_time(double seconds, char *text, unsigned size)
{
    if (!(seconds >= 0 && seconds < 1e9)) {
        snprintf(text, size, "-");
        return;
    }
    const long s = lround(seconds);
    if (s < 3600)
        snprintf(text, size, "%ld:%02ld", s / 60, s % 60);
    else
        snprintf(text, size, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
}

static double number(const json_t *status, const char *name)
{
    const json_t *value = json_get(status, name);
    return value && json_is_number(value) ? json_number(value) : (double)NAN;
}

static const char *text_of(const json_t *status, const char *name)
{
    const json_t *value = json_get(status, name);
    const char *text = value ? json_string(value) : NULL;
    return text ? text : "";
}

static void measure_rate(progress_bar_t *bar, double mutations, double now)
{
    const double step = now - bar->last_seen;
    if (bar->last_seen > 0 && step > 0 && mutations >= bar->last_mutations) {
        const double weight = 1 - exp(-step / smoothing_seconds);
        const double rate = (mutations - bar->last_mutations) / step;
        bar->rate = bar->rate > 0 ? bar->rate + weight * (rate - bar->rate) : rate;
    }
    bar->last_seen = now;
    bar->last_mutations = mutations;
}

static void describe(const progress_bar_t *bar, const json_t *status, char line[LINE_SIZE])
{
    const char *state = text_of(status, "state");
    if (strcmp(state, "running") != 0) {
        snprintf(line, LINE_SIZE, "%s", strcmp(state, "queued") == 0 ? "setting up" : state);
        return;
    }
    const double fraction = fmin(1, fmax(0, number(status, "fraction")));
    const double error = number(status, "error");
    char left[32], gauge[BAR_WIDTH + 1], known[32] = "";
    const int filled = (int)(fraction * BAR_WIDTH);
    for (int i = 0; i < BAR_WIDTH; i++)
        gauge[i] = i < filled ? '#' : '.';
    gauge[BAR_WIDTH] = '\0';
    progress_bar_time(number(status, "seconds_left"), left, sizeof left);
    if (isfinite(error))
        snprintf(known, sizeof known, "  error %.2f %%", 100 * error);
    snprintf(line, LINE_SIZE, "%s%s%s%5.1f %%  %-6s  %.3g mutations/s%s  %s left", bar->terminal ? "[" : "",
             bar->terminal ? gauge : "", bar->terminal ? "]" : "", 100 * fraction, text_of(status, "phase"),
             bar->rate, known, left);
}

void progress_bar_say(progress_bar_t *bar, const char *text)
{
    if (bar->shown && bar->terminal)
        fputs("\r\033[K", stderr);
    bar->shown = false;
    fprintf(stderr, "%s\n", text);
}

static void say_trouble(progress_bar_t *bar, const char *trouble)
{
    if (strncmp(trouble, bar->trouble, sizeof bar->trouble - 1) == 0)
        return;
    snprintf(bar->trouble, sizeof bar->trouble, "%s", trouble);
    char line[LINE_SIZE + 32];
    snprintf(line, sizeof line, "garland: %s", trouble[0] ? bar->trouble : "goes on");
    progress_bar_say(bar, line);
}

void progress_bar_show(progress_bar_t *bar, const json_t *status)
{
    const double now = clock_now();
    measure_rate(bar, number(status, "mutations"), now);
    say_trouble(bar, text_of(status, "trouble"));
    if (bar->quiet || now < bar->next)
        return;
    char line[LINE_SIZE];
    describe(bar, status, line);
    fprintf(stderr, bar->terminal ? "\r%s\033[K" : "%s\n", line);
    fflush(stderr);
    bar->shown = true;
    bar->next = now + (bar->terminal ? terminal_interval : line_interval);
}

void progress_bar_end(progress_bar_t *bar)
{
    if (bar->shown && bar->terminal)
        fputs("\r\033[K", stderr);
    bar->shown = false;
}
