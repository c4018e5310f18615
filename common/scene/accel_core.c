#include "scene/accel_core.h"

/* Coordinates of what belongs to the core are below this fraction of the largest. */
#define CORE_FRACTION 0x1p-10
/* Of the largest coordinate: the box's margin, larger than the overlap, so that nothing of the core lies where that
 * is.
 */
#define CORE_MARGIN 0x1p-20

typedef void visit_fn(void *context, vec3_t low, vec3_t high);

static vec3_t corner_of(const scene_t *scene, const scene_shape_t *shape, uint32_t triangle, int corner)
{
    const uint32_t index = scene->indices[3 * ((size_t)shape->first_triangle + triangle) + (size_t)corner];
    const float *p = scene->positions + 3 * ((size_t)shape->first_vertex + index);
    return vec3(p[0], p[1], p[2]);
}

/* Calls visit with the box of every primitive. */
static void visit_boxes(const scene_t *scene, visit_fn *visit, void *context)
{
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *shape = &scene->shapes[i];
        if (shape->kind != SCENE_SHAPE_MESH) {
            const vec3_t c = vec3(shape->centre[0], shape->centre[1], shape->centre[2]);
            const double r = shape->radius;
            visit(context, vec3(c.x - r, c.y - r, c.z - r), vec3(c.x + r, c.y + r, c.z + r));
            continue;
        }
        for (uint32_t j = 0; j < shape->triangles; j++) {
            const vec3_t a = corner_of(scene, shape, j, 0), b = corner_of(scene, shape, j, 1),
                         c = corner_of(scene, shape, j, 2);
            visit(context, vec3_min(a, vec3_min(b, c)), vec3_max(a, vec3_max(b, c)));
        }
    }
}

static double box_extent(vec3_t low, vec3_t high)
{
    return math_max(vec3_max_abs(low), vec3_max_abs(high));
}

static void visit_extent(void *context, vec3_t low, vec3_t high)
{
    accel_core_t *core = context;
    core->extent = math_max(core->extent, box_extent(low, high));
}

static void visit_core(void *context, vec3_t low, vec3_t high)
{
    accel_core_t *core = context;
    if (box_extent(low, high) >= CORE_FRACTION * core->extent)
        return;
    core->low = core->exists ? vec3_min(core->low, low) : low;
    core->high = core->exists ? vec3_max(core->high, high) : high;
    core->exists = true;
}

/* The extent, and the core's box with its own size and the margin on each side. */
void accel_core_init(accel_core_t *core, const scene_t *scene)
{
    *core = (accel_core_t){0};
    visit_boxes(scene, visit_extent, core);
    visit_boxes(scene, visit_core, core);
    const double *m = scene->camera ? scene->camera->to_world : NULL;
    if (m)
        core->extent = math_max(core->extent, vec3_max_abs(vec3(m[3], m[7], m[11])));
    const double margin = vec3_max_abs(vec3_sub(core->high, core->low)) + CORE_MARGIN * core->extent;
    core->low = vec3_sub(core->low, vec3(margin, margin, margin));
    core->high = vec3_add(core->high, vec3(margin, margin, margin));
}

/* Narrows [*begin, *end] to where the line is between low and high. */
static void clip_to_slab(double origin, double direction, double low, double high, double *begin, double *end)
{
    if (direction == 0) {
        if (origin < low || origin > high)
            *end = -1;
        return;
    }
    const double a = (low - origin) / direction, b = (high - origin) / direction;
    *begin = math_max(*begin, math_min(a, b));
    *end = math_min(*end, math_max(a, b));
}

double accel_core_entry(const accel_core_t *core, vec3_t o, vec3_t d)
{
    double begin = 0, end = INFINITY;
    clip_to_slab(o.x, d.x, core->low.x, core->high.x, &begin, &end);
    clip_to_slab(o.y, d.y, core->low.y, core->high.y, &begin, &end);
    clip_to_slab(o.z, d.z, core->low.z, core->high.z, &begin, &end);
    return begin < end ? begin : 0;
}
