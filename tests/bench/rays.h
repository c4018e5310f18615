/* rays.h: what a render asks of Embree, seen from outside: the linker's --wrap=rtcIntersect1 and
 * --wrap=rtcOccluded1 lead those calls through this file, so that the renderer itself carries no hooks.
 *
 * RAYS_PASS costs a predicted branch a ray (about a nanosecond), RAYS_RECORD copies each ray, RAYS_TIME reads the
 * time stamp counter before and after each call.
 *
 *     rays_start(RAYS_RECORD);
 *     work_run(...);
 *     rays_stop();
 *     seconds = rays_replay();      the same calls once more, nothing in between
 *
 * Recording and timing are for one thread at a time; passing is for any number. Mode changes only while nothing
 * renders.
 */
#ifndef TESTS_BENCH_RAYS_H
#define TESTS_BENCH_RAYS_H

#include <stddef.h>
#include <stdint.h>

typedef enum rays_mode { RAYS_PASS = 0, RAYS_RECORD = 1, RAYS_TIME = 2 } rays_mode_t;

/* The rays of one stretch of work, in their order. */
typedef struct rays_log {
    struct rays_call *calls;
    size_t count, room;
    uint64_t seen; /* calls, those without room included */
} rays_log_t;

/* Records up to `room` rays into log, which rays_log_clear releases; 0 if there is no memory. */
int rays_log_init(rays_log_t *log, size_t room);
void rays_log_clear(rays_log_t *log);

/* Sets the mode; `log` is for RAYS_RECORD, which empties it. */
void rays_start(rays_mode_t mode, rays_log_t *log);
void rays_stop(void); /* back to RAYS_PASS */

/* Time stamps spent inside Embree since rays_start(RAYS_TIME), the clock's own cost taken off; calls in which the
 * thread was interrupted are left out. */
uint64_t rays_ticks_inside(void);
uint64_t rays_ticks_now(void);
double rays_ticks_per_second(void); /* measured for 20 ms */

/* Traces the recorded rays again, in their order; CPU seconds of the calls, the loop's own cost taken off. */
double rays_replay(const rays_log_t *log);

#endif
