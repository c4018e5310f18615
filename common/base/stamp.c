#include "base/stamp.h"

#include <x86intrin.h>

#include "base/clock.h"

/* Not before what stands before it has ended, and not after what stands behind it has begun. */
static inline uint64_t stamp_now(void)
{
    _mm_lfence();
    const uint64_t now = __rdtsc();
    _mm_lfence();
    return now;
}

void stamp_begin(stamp_meter_t *meter, stamp_watch_t *watch)
{
    meter->calls = 0;
    meter->gap = meter->left;
    meter->samples = meter->ticks = 0;
    *watch = (stamp_watch_t){clock_now(), stamp_now()};
}

uint64_t stamp_open(stamp_meter_t *meter)
{
    meter->calls += meter->gap + 1;
    meter->state = meter->state * 1664525u + 1013904223u; /* Knuth; Numerical Recipes, 7.1 */
    meter->gap = meter->left = STAMP_LEAST_GAP + (meter->state >> 16) % STAMP_GAPS;
    const uint64_t before = stamp_now(), now = stamp_now();
    meter->overhead = now - before;
    return now;
}

void stamp_close(stamp_meter_t *meter, uint64_t from)
{
    const uint64_t ticks = stamp_now() - from;
    if (ticks > STAMP_MOST_TICKS)
        return;
    meter->ticks += ticks > meter->overhead ? ticks - meter->overhead : 0;
    meter->samples++;
}

double stamp_seconds(const stamp_meter_t *meter, const stamp_watch_t *watch)
{
    const uint64_t ticks = stamp_now() - watch->ticks;
    if (meter->samples == 0 || ticks == 0)
        return 0;
    const double calls = (double)(meter->calls + (meter->gap - meter->left));
    return (double)meter->ticks / (double)meter->samples * calls * ((clock_now() - watch->wall) / (double)ticks);
}
