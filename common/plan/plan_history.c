#include "plan/plan_history.h"

#include <math.h>
#include <string.h>

static double history_gap(const plan_history_t *history, uint32_t i)
{
    const double before = history->points[i - 1].cpu_seconds, after = history->points[i + 1].cpu_seconds;
    return before > 0 ? after / before : INFINITY;
}

static void history_thin(plan_history_t *history)
{
    uint32_t least = 1;
    for (uint32_t i = 2; i + 1 < history->count; i++)
        if (history_gap(history, i) < history_gap(history, least))
            least = i;
    memmove(history->points + least, history->points + least + 1,
            sizeof *history->points * (history->count - least - 1));
    history->count--;
}

void plan_history_add(plan_history_t *history, const plan_point_t *point)
{
    if (!isfinite(point->relmse) || !isfinite(point->cpu_seconds) || !(point->relmse > 0))
        return;
    if (history->count > 0 && point->cpu_seconds <= history->points[history->count - 1].cpu_seconds) {
        if (point->cpu_seconds == history->points[history->count - 1].cpu_seconds)
            history->points[history->count - 1] = *point;
        return;
    }
    if (history->count == PLAN_HISTORY)
        history_thin(history);
    history->points[history->count++] = *point;
}
