#include "stats/history.h"

#include <math.h>
#include <string.h>

static double history_gap(const history_t *history, uint32_t i)
{
    const double before = history->points[i - 1].cpu_seconds, after = history->points[i + 1].cpu_seconds;
    return before > 0 ? after / before : INFINITY;
}

static void history_thin(history_t *history)
{
    uint32_t least = 1;
    for (uint32_t i = 2; i + 1 < history->count; i++)
        if (history_gap(history, i) < history_gap(history, least))
            least = i;
    memmove(history->points + least, history->points + least + 1,
            sizeof *history->points * (history->count - least - 1));
    history->count--;
}

void history_add(history_t *history, const history_point_t *point)
{
    if (!isfinite(point->relmse) || !isfinite(point->cpu_seconds) || !(point->relmse > 0) ||
        !(point->outlook > 0 && point->outlook <= point->relmse))
        return;
    if (history->count > 0 && point->cpu_seconds <= history->points[history->count - 1].cpu_seconds) {
        if (point->cpu_seconds == history->points[history->count - 1].cpu_seconds)
            history->points[history->count - 1] = *point;
        return;
    }
    if (history->count == HISTORY_POINTS)
        history_thin(history);
    history->points[history->count++] = *point;
}

void history_put(wire_writer_t *out, const history_t *history)
{
    wire_put_u32(out, history->count);
    for (uint32_t i = 0; i < history->count; i++) {
        const history_point_t *point = &history->points[i];
        wire_put_f64(out, point->seconds);
        wire_put_f64(out, point->cpu_seconds);
        wire_put_f64(out, point->mutations);
        wire_put_f64(out, point->relmse);
        wire_put_f64(out, point->spread);
        wire_put_f64(out, point->outlook);
    }
}

fault_code_t history_get(wire_reader_t *in, history_t *history)
{
    const uint32_t count = wire_get_u32(in, "history");
    if (!in->code && count > HISTORY_POINTS)
        return wire_reader_fail(in, FAULT_RANGE, "history", "%u points, expected at most %d", count,
                                HISTORY_POINTS);
    for (uint32_t i = 0; i < count && !in->code; i++) {
        history_point_t point;
        point.seconds = wire_get_f64(in, "history");
        point.cpu_seconds = wire_get_f64(in, "history");
        point.mutations = wire_get_f64(in, "history");
        point.relmse = wire_get_f64(in, "history");
        point.spread = wire_get_f64(in, "history");
        point.outlook = wire_get_f64(in, "history");
        history_add(history, &point);
        if (!in->code &&
            (history->count != i + 1 || !(point.seconds >= 0 && point.cpu_seconds >= 0 && point.mutations >= 0)))
            return wire_reader_fail(in, FAULT_RANGE, "history", "point %u is negative, or not after the one before",
                                    i);
    }
    return in->code;
}
