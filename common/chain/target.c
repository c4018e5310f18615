#include "chain/target.h"

#include <string.h>

static void target_add(target_t *target, uint32_t s)
{
    target->list[target->count++] = (uint8_t)s;
    target->techniques.allowed[s] = 1;
    const uint32_t camera = path_camera_dimensions(target->scene, target->length + 1 - s),
                   light = path_light_dimensions(s);
    target->camera_count = camera > target->camera_count ? camera : target->camera_count;
    target->light_count = light > target->light_count ? light : target->light_count;
}

void target_init(target_t *target, const path_scene_t *scene, const settings_t *settings, uint32_t length)
{
    memset(target, 0, sizeof *target);
    target->scene = scene;
    target->length = length;
    target->kind = settings->target;
    target->techniques.left_out =
        (uint8_t)((settings_forbids(settings, SETTINGS_CAUSTICS) ? PATH_CLASS_CAUSTIC : 0) |
                  (settings_forbids(settings, SETTINGS_ENVIRONMENT) ? PATH_CLASS_INFINITE : 0));
    if (length == 1 && settings_forbids(settings, SETTINGS_EMISSION))
        return; /* no technique makes such paths */
    for (uint32_t s = 0; s <= length; s++) {
        if (s == 0 && !scene->lights.can_hit)
            continue; /* only lights without extent: no camera walk ends on one */
        if (s > 1 && settings->algorithm == SETTINGS_PT)
            continue;
        if (length == 1 && s == 1 && !scene->lights.can_hit)
            continue; /* a light without extent is not to be seen itself */
        target_add(target, s);
    }
}

void target_leave(target_t *target, const target_idle_t *idle)
{
    uint8_t before[PATH_MAX_VERTICES];
    memcpy(before, target->techniques.allowed, sizeof before);
    memset(target->techniques.allowed, 0, sizeof before);
    target->count = target->camera_count = target->light_count = 0;
    for (uint32_t s = 0; s <= target->length; s++)
        if (before[s] && !target_is_idle(idle, s))
            target_add(target, s);
}

bool target_walk_camera(const target_t *target, path_space_t *space, uint32_t s, const double *camera)
{
    const uint32_t t = target->length + 1 - s;
    if (s == 0)
        return path_walk_camera(target->scene, space, camera, t, PATH_ENDS_ON_LIGHT) == t;
    return path_walk_camera(target->scene, space, camera, t, PATH_ENDS_JOINED) == t &&
           path_can_join(&space->camera[t - 1]);
}

bool target_walk_light(const target_t *target, path_space_t *space, uint32_t s, const double *light)
{
    return path_walk_light(target->scene, space, light, s, PATH_ENDS_JOINED) == s &&
           path_can_join(&space->light[s - 1]);
}

void target_join(const target_t *target, path_space_t *space, uint32_t s, target_value_t *out)
{
    path_value_t value;
    out->c = 0;
    if (path_connect(target->scene, space, s, target->length + 1 - s, NULL, &target->techniques, &value))
        target_value_of(target, &value, out);
}

void target_eval(const target_t *target, path_space_t *space, uint32_t s, const double *camera, const double *light,
                 target_value_t *out)
{
    const bool light_first = target_light_first(target, s);
    out->c = 0;
    if (light_first && !target_walk_light(target, space, s, light))
        return;
    if (!target_walk_camera(target, space, s, camera))
        return;
    if (s > 0 && !light_first && !target_walk_light(target, space, s, light))
        return;
    target_join(target, space, s, out);
}
