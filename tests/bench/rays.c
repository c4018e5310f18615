#include "rays.h"

#include <embree3/rtcore.h>
#include <stdlib.h>
#include <x86intrin.h>

#include "base/clock.h"

/* Ticks of a call, tens of microseconds, that something else ran in: no ray takes so long. */
enum { INTERRUPTED = 100000 };

typedef struct rays_call {
    RTCScene scene;
    struct RTCRayHit rayhit; /* of a shadow ray only the ray */
    int occluded;
} rays_call_t;

static rays_mode_t mode;
static rays_log_t *recording;
static uint64_t ticks_inside, calls_timed, ticks_clock;

void __real_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *rayhit);
void __real_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray);
void __wrap_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *rayhit);
void __wrap_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray);

uint64_t rays_ticks_now(void)
{
    unsigned core;
    return __rdtscp(&core);
}

double rays_ticks_per_second(void)
{
    const uint64_t ticks = rays_ticks_now();
    const double start = clock_now();
    double seconds = 0;
    while (seconds < 0.02)
        seconds = clock_now() - start;
    return (double)(rays_ticks_now() - ticks) / seconds;
}

int rays_log_init(rays_log_t *log, size_t room)
{
    *log = (rays_log_t){.room = room};
    return posix_memalign((void **)&log->calls, _Alignof(rays_call_t), room * sizeof *log->calls) == 0;
}

void rays_log_clear(rays_log_t *log)
{
    free(log->calls);
    *log = (rays_log_t){0};
}

/* The least that two readings of the clock are apart: what a timed call measures too much. */
static uint64_t rays_clock_cost(void)
{
    uint64_t least = UINT64_MAX;
    for (int i = 0; i < 10000; i++) {
        const uint64_t start = rays_ticks_now(), ticks = rays_ticks_now() - start;
        least = ticks < least ? ticks : least;
    }
    return least;
}

void rays_start(rays_mode_t new_mode, rays_log_t *log)
{
    mode = new_mode;
    recording = log;
    if (log)
        log->count = log->seen = 0;
    ticks_inside = calls_timed = 0;
    if (mode == RAYS_TIME)
        ticks_clock = rays_clock_cost();
}

void rays_stop(void)
{
    mode = RAYS_PASS;
    recording = NULL;
}

uint64_t rays_ticks_inside(void)
{
    const uint64_t cost = calls_timed * ticks_clock;
    return ticks_inside > cost ? ticks_inside - cost : 0;
}

static void rays_record_hit(RTCScene scene, const struct RTCRayHit *rayhit)
{
    recording->seen++;
    if (recording->count < recording->room)
        recording->calls[recording->count++] = (rays_call_t){scene, *rayhit, 0};
}

static void rays_record_shadow(RTCScene scene, const struct RTCRay *ray)
{
    recording->seen++;
    if (recording->count < recording->room)
        recording->calls[recording->count++] = (rays_call_t){scene, {.ray = *ray}, 1};
}

static void rays_count(uint64_t ticks)
{
    if (ticks > INTERRUPTED)
        return;
    ticks_inside += ticks;
    calls_timed++;
}

__attribute__((noinline, cold)) static void intersect_watched(RTCScene scene, struct RTCIntersectContext *context,
                                                              struct RTCRayHit *rayhit)
{
    if (mode == RAYS_RECORD)
        rays_record_hit(scene, rayhit);
    const uint64_t start = rays_ticks_now();
    __real_rtcIntersect1(scene, context, rayhit);
    rays_count(rays_ticks_now() - start);
}

__attribute__((noinline, cold)) static void occluded_watched(RTCScene scene, struct RTCIntersectContext *context,
                                                             struct RTCRay *ray)
{
    if (mode == RAYS_RECORD)
        rays_record_shadow(scene, ray);
    const uint64_t start = rays_ticks_now();
    __real_rtcOccluded1(scene, context, ray);
    rays_count(rays_ticks_now() - start);
}

void __wrap_rtcIntersect1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *rayhit)
{
    if (__builtin_expect(mode != RAYS_PASS, 0))
        intersect_watched(scene, context, rayhit);
    else
        __real_rtcIntersect1(scene, context, rayhit);
}

void __wrap_rtcOccluded1(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray)
{
    if (__builtin_expect(mode != RAYS_PASS, 0))
        occluded_watched(scene, context, ray);
    else
        __real_rtcOccluded1(scene, context, ray);
}

/* In the place of Embree, for the cost of the loop. */
static void trace_nothing(RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit *rayhit)
{
    (void)scene;
    (void)context;
    (void)rayhit;
}

static void trace_nothing_shadow(RTCScene scene, struct RTCIntersectContext *context, struct RTCRay *ray)
{
    (void)scene;
    (void)context;
    (void)ray;
}

/* Behind volatile pointers, so that no call is inlined and none removed. */
static void (*volatile intersect_calls[2])(RTCScene, struct RTCIntersectContext *,
                                           struct RTCRayHit *) = {trace_nothing, __real_rtcIntersect1};
static void (*volatile occluded_calls[2])(RTCScene, struct RTCIntersectContext *,
                                          struct RTCRay *) = {trace_nothing_shadow, __real_rtcOccluded1};

/* CPU seconds of all calls, with Embree or with nothing behind them. */
static double replay(const rays_log_t *log, int with)
{
    void (*const intersect)(RTCScene, struct RTCIntersectContext *, struct RTCRayHit *) = intersect_calls[with];
    void (*const occluded)(RTCScene, struct RTCIntersectContext *, struct RTCRay *) = occluded_calls[with];
    const double start = clock_thread_cpu();
    for (size_t i = 0; i < log->count; i++) {
        struct RTCIntersectContext context;
        struct RTCRayHit rayhit = log->calls[i].rayhit;
        rtcInitIntersectContext(&context);
        if (log->calls[i].occluded)
            occluded(log->calls[i].scene, &context, &rayhit.ray);
        else
            intersect(log->calls[i].scene, &context, &rayhit);
    }
    return clock_thread_cpu() - start;
}

double rays_replay(const rays_log_t *log)
{
    const double calls = replay(log, 1);
    return calls - replay(log, 0);
}
