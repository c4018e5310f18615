/* round_trip.c: paths of hard scenes to numbers and back. */
#include "hard.h"

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "inverse_trip.h"

typedef bool invert_fn(const path_scene_t *, const path_space_t *, uint32_t, uint32_t, uint32_t, uint64_t, double *,
                       double *);

typedef struct tally {
    const char *name;
    invert_fn *invert;
    double tolerance;
    uint64_t trips, causes[PATH_INVERSE_FAILURES], off;
    double moved, changed;
} tally_t;

static const double tolerance_of_one = 1e-7, share_off = 1e-3;

static void check_numbers(const char *name, const double *u, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (!(u[i] >= 0 && u[i] < 1))
            fail_msg("%s: number %u is %.17g", name, i, u[i]);
}

/* x, made by technique s with the contribution c, to numbers of technique j and back. */
static void make_trip(trip_t *trip, uint32_t s, uint32_t j, double c, uint64_t key, tally_t *tally)
{
    const uint32_t t = trip->target.length + 1 - s;
    path_check_t check = {.error = 0};
    memcpy(trip->camera_new, trip->camera, sizeof trip->camera);
    memcpy(trip->light_new, trip->light, sizeof trip->light);
    path_inverse_failure_t cause = PATH_INVERSE_VOID;
    if (tally->invert(&trip->ps, trip->x, s, t, j, key, trip->camera_new, trip->light_new)) {
        check_numbers(tally->name, trip->camera_new, trip->target.camera_count);
        check_numbers(tally->name, trip->light_new, trip->target.light_count);
        cause = path_verify(&trip->ps, trip->x, s, t, trip->y, j, trip->camera_new, trip->light_new,
                            &trip->target.techniques, &check);
    }
    tally->trips++;
    tally->causes[cause]++;
    if (cause != PATH_INVERSE_AGREES)
        return;
    const double again = target_scalar(trip->target.kind, check.value.value);
    if (!(again > 0 && isfinite(again)))
        fail_msg("%s, length %u, s = %u to %u: C is %g, made again %g", tally->name, trip->target.length, s, j, c,
                 again);
    const double changed = fabs(again - c) / fmax(again, c);
    tally->off += !(changed <= tally->tolerance);
    tally->moved = fmax(tally->moved, check.error);
    tally->changed = fmax(tally->changed, changed);
}

static void make_trips(trip_t *trip, uint32_t length, uint32_t paths, tally_t *tally)
{
    const target_t *target = &trip->target;
    trip_length(trip, length);
    for (uint32_t i = 0; i < paths && target->count > 0; i++) {
        const uint64_t key = random_key(53, RANDOM_PURPOSE_TEST, length, i);
        const uint32_t s = target->list[i % target->count];
        trip_numbers(trip, key, false);
        const double c = trip_make(trip, s);
        for (uint32_t j = 0; j < target->count && c > 0; j++)
            if (trip_possible(trip, s, target->list[j]))
                make_trip(trip, s, target->list[j], c, random_step(key, j), tally);
    }
}

void hard_expect_round_trips(const char *name, const scene_t *scene, const hard_round_trip_t *options)
{
    static trip_t trip;
    trip_open(&trip, scene);
    invert_fn *const ways[2] = {path_invert, path_invert_jump};
    for (int way = 0; way < 2; way++) {
        tally_t tally = {.name = name, .invert = ways[way], .tolerance = tolerance_of_one / options->width};
        for (uint32_t k = options->shortest; k <= options->longest; k++)
            make_trips(&trip, k, options->paths, &tally);
        const uint64_t *c = tally.causes;
        const double failing = (double)(tally.trips - c[PATH_INVERSE_AGREES]) / (double)tally.trips;
        print_message(
            "%s, numbers %s: %llu round trips, share failing %.2g (void %llu, short %llu, kind %llu, moved "
            "%llu, dark %llu), largest movement %.2g, change of C %.2g, %llu off\n",
            name, way ? "kept" : "anew", (unsigned long long)tally.trips, failing,
            (unsigned long long)c[PATH_INVERSE_VOID], (unsigned long long)c[PATH_INVERSE_SHORT],
            (unsigned long long)c[PATH_INVERSE_KIND], (unsigned long long)c[PATH_INVERSE_MOVED],
            (unsigned long long)c[PATH_INVERSE_CARRIES_NOTHING], tally.moved, tally.changed,
            (unsigned long long)tally.off);
        hard_record(HARD_LOST, (double)tally.trips, (double)(tally.trips - c[PATH_INVERSE_AGREES]));
        hard_record(HARD_CHANGE, (double)tally.trips, tally.changed);
        assert_true(tally.trips >= options->least);
        assert_true(failing <= options->failing);
        assert_true((double)tally.off <= share_off * (double)tally.trips);
    }
    trip_close(&trip);
}
