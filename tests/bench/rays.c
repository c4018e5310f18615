#include "rays.h"

#include <embree3/rtcore.h>
#include <stdlib.h>
#include <x86intrin.h>

#include "base/clock.h"

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

uint64_t rays_calls_timed(void)
{
    return calls_timed;
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

__attribute__((noinline, cold)) static void intersect_watched(RTCScene scene, struct RTCIntersectContext *context,
                                                              struct RTCRayHit *rayhit)
{
    if (mode == RAYS_RECORD)
        rays_record_hit(scene, rayhit);
    const uint64_t start = rays_ticks_now();
    __real_rtcIntersect1(scene, context, rayhit);
    ticks_inside += rays_ticks_now() - start;
    calls_timed++;
}

__attribute__((noinline, cold)) static void occluded_watched(RTCScene scene, struct RTCIntersectContext *context,
                                                             struct RTCRay *ray)
{
    if (mode == RAYS_RECORD)
        rays_record_shadow(scene, ray);
    const uint64_t start = rays_ticks_now();
    __real_rtcOccluded1(scene, context, ray);
    ticks_inside += rays_ticks_now() - start;
    calls_timed++;
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
__attribute__((noipa)) static void trace_nothing(RTCScene scene, struct RTCIntersectContext *context,
                                                 struct RTCRayHit *rayhit)
{
    (void)scene;
    (void)context;
    (void)rayhit;
}

__attribute__((noipa)) static void trace_nothing_shadow(RTCScene scene, struct RTCIntersectContext *context,
                                                        struct RTCRay *ray)
{
    (void)scene;
    (void)context;
    (void)ray;
}

__attribute__((noipa)) static double
replay(const rays_log_t *log, void (*intersect)(RTCScene, struct RTCIntersectContext *, struct RTCRayHit *),
       void (*occluded)(RTCScene, struct RTCIntersectContext *, struct RTCRay *))
{
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
    const double calls = replay(log, __real_rtcIntersect1, __real_rtcOccluded1);
    return calls - replay(log, trace_nothing, trace_nothing_shadow);
}
