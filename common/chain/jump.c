#include "chain/jump.h"

#include <string.h>

#include "path/inverse.h"

/* A technique by the path's weights. */
static uint32_t jump_draw(const double *weights, uint32_t techniques, uint32_t s, double u)
{
    for (uint32_t j = 0; j < techniques; j++) {
        if (u < weights[j])
            return j;
        u -= weights[j];
    }
    return s; /* by rounding */
}

bool jump_propose(work_space_t *space, const target_t *target, uint32_t s, uint64_t key, uint32_t *s_new,
                  target_value_t *value)
{
    const uint32_t k = target->length, t = k + 1 - s;
    double weights[PATH_MAX_VERTICES];
    /* the walks of the current path: the space holds those of the last proposal */
    target_eval(target, &space->path, s, space->camera, space->light, value);
    if (!(value->c > 0) || !path_technique_weights(&space->path, s, t, &target->techniques, weights))
        return false;
    *s_new = jump_draw(weights, k + 1, s, random_double(key, UNIT_DRAW_TECHNIQUE));
    if (*s_new == s)
        return true;
    memcpy(space->camera_new, space->camera, sizeof(double) * target->camera_count);
    memcpy(space->light_new, space->light, sizeof(double) * target->light_count);
    path_check_t check;
    if (!path_invert_jump(target->scene, &space->path, s, t, *s_new, key, space->camera_new, space->light_new) ||
        path_verify(target->scene, &space->path, s, t, space->other, *s_new, space->camera_new, space->light_new,
                    &target->techniques, &check) != PATH_INVERSE_AGREES)
        return false;
    value->c = target_scalar(target->kind, check.value.value);
    if (!(value->c > 0))
        return false;
    value->color = rgb_scale(check.value.value, 1 / value->c);
    value->raster = check.value.raster;
    return true;
}
