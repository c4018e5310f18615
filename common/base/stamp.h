/* stamp.h: how much of a thread's time goes into a kind of call, from a sample of the calls: about one of 64 is
 * timed, at irregular distances so that no rhythm of the work can hide from it. The others cost a decrement. For
 * reports to people; no result may depend on it.
 *
 *     stamp_meter_t meter = {0};
 *     stamp_watch_t watch;
 *     stamp_begin(&meter, &watch);                    at the beginning of a piece of work
 *     for (...) {
 *         const uint64_t from = stamp_enter(&meter);
 *         call();
 *         stamp_leave(&meter, from);
 *     }
 *     seconds = stamp_seconds(&meter, &watch);
 *
 * Times are read from the processor's time stamp counter, whose rate comes from the piece of work itself: its wall
 * time over its ticks. What the reading itself takes is measured along with each sample and taken off. A sample of
 * more than STAMP_MOST_TICKS is that of an interrupted thread and is left out.
 *
 * Thread rule: a meter belongs to one thread. x86-64 only.
 */
#ifndef BASE_STAMP_H
#define BASE_STAMP_H

#include <stdint.h>

enum {
    STAMP_LEAST_GAP = 32,      /* calls from one that is timed to the next: 32 ... */
    STAMP_GAPS = 64,           /* ... to 95 */
    STAMP_MOST_TICKS = 1 << 18 /* a tenth of a millisecond or so */
};

typedef struct stamp_meter {
    uint32_t left;  /* calls until one is timed; 0: the next is */
    uint32_t state; /* of the gaps */
    uint64_t calls; /* as of the last that was timed */
    uint64_t gap;
    uint64_t samples, ticks; /* ticks: of all samples */
    uint64_t overhead;       /* of the sample at hand */
} stamp_meter_t;

/* When a piece of work began. */
typedef struct stamp_watch {
    double wall;
    uint64_t ticks;
} stamp_watch_t;

/* Forgets what was counted; the sequence of gaps goes on. */
void stamp_begin(stamp_meter_t *meter, stamp_watch_t *watch);

/* The two ends of a call that is timed; for the functions below. */
uint64_t stamp_open(stamp_meter_t *meter);
void stamp_close(stamp_meter_t *meter, uint64_t from);

/* 0, unless this call is timed. */
static inline uint64_t stamp_enter(stamp_meter_t *meter)
{
    if (__builtin_expect(meter->left > 0, 1)) {
        meter->left--;
        return 0;
    }
    return stamp_open(meter);
}

static inline void stamp_leave(stamp_meter_t *meter, uint64_t from)
{
    if (__builtin_expect(from != 0, 0))
        stamp_close(meter, from);
}

/* Time in all the calls since stamp_begin, estimated; 0 if none was timed. */
double stamp_seconds(const stamp_meter_t *meter, const stamp_watch_t *watch);

#endif
