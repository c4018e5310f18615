#include "inverse_trip.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "base/random.h"
#include "inverse_scenes.h"

void trip_begin(trip_t *trip, const char *name)
{
    trip_open(trip, inverse_scene(name));
}

void trip_open(trip_t *trip, const scene_t *scene)
{
    fault_t fault = {0};
    if (path_scene_init(&trip->ps, scene, scene->camera, 0, 0, &fault))
        fail_msg("%s", fault.text);
    trip->x = path_space_new();
    trip->y = path_space_new();
    assert_non_null(trip->x);
    assert_non_null(trip->y);
    trip->z = path_space_new();
    assert_non_null(trip->z);
}

void trip_length(trip_t *trip, uint32_t k)
{
    settings_t settings;
    settings_default(&settings);
    target_init(&trip->target, &trip->ps, &settings, k);
}

void trip_close(trip_t *trip)
{
    free(trip->x);
    free(trip->y);
    free(trip->z);
    path_scene_clear(&trip->ps);
}

void trip_end(trip_t *trip)
{
    trip_close(trip);
    inverse_scene_clear();
}

static double number(uint64_t key, uint64_t i, bool extreme)
{
    const double choice = random_double(key, 5000 + i);
    return !extreme || choice > 0.2 ? random_double(key, i) : choice < 0.1 ? 0 : MATH_ONE_MINUS;
}

void trip_numbers(trip_t *trip, uint64_t key, bool extreme)
{
    for (uint32_t i = 0; i < trip->target.camera_count; i++)
        trip->camera[i] = number(key, i, extreme);
    for (uint32_t i = 0; i < trip->target.light_count; i++)
        trip->light[i] = number(key, 1000 + i, extreme);
}

double trip_make(trip_t *trip, uint32_t s)
{
    const uint32_t t = trip->target.length + 1 - s;
    path_value_t value;
    if (path_walk_camera(&trip->ps, trip->x, trip->camera, t, PATH_ENDS_ANYWHERE) < t ||
        (s > 0 && path_walk_light(&trip->ps, trip->x, trip->light, s, PATH_ENDS_ANYWHERE) < s) ||
        !path_connect(&trip->ps, trip->x, s, t, NULL, &trip->target.techniques, &value))
        return 0;
    return target_scalar(trip->target.kind, value.value);
}

const path_vertex_t *trip_vertex(const trip_t *trip, uint32_t s, uint32_t i)
{
    return i < s ? &trip->x->light[i] : &trip->x->camera[trip->target.length - i];
}

bool trip_possible(const trip_t *trip, uint32_t s, uint32_t j)
{
    if (j == 0)
        return s == 0 || !trip->x->light[0].delta;
    for (uint32_t i = j - 1; i <= j; i++)
        if (i + 1 != s && i != s && trip_vertex(trip, s, i)->specular)
            return false;
    return true;
}

bool trip_invert(trip_t *trip, uint32_t s, uint32_t j, uint64_t key)
{
    return path_invert(&trip->ps, trip->x, s, trip->target.length + 1 - s, j, key, trip->camera_new,
                       trip->light_new);
}
