#include "scene/light.h"

#include <stdlib.h>
#include <string.h>

#include "scene/environment.h"

/* By how much the bounding sphere is larger than needed: photons must start outside of everything in single
 * precision too. */
#define LIGHT_SPHERE_MARGIN 1e-4

static vec3_t vec3_of(const float *p)
{
    return vec3(p[0], p[1], p[2]);
}

static rgb_t rgb_of(const float *p)
{
    return rgb(p[0], p[1], p[2]);
}

/* ---- the bounding sphere ---- */

typedef struct box {
    vec3_t low, high;
} box_t;

static void box_grow(box_t *box, vec3_t p, double radius)
{
    box->low = vec3(fmin(box->low.x, p.x - radius), fmin(box->low.y, p.y - radius), fmin(box->low.z, p.z - radius));
    box->high =
        vec3(fmax(box->high.x, p.x + radius), fmax(box->high.y, p.y + radius), fmax(box->high.z, p.z + radius));
}

/* Calls visit for every point, with the radius of what is around it. */
static void visit_extent(const scene_t *scene, void (*visit)(void *context, vec3_t p, double radius), void *context)
{
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        const scene_shape_t *shape = &scene->shapes[i];
        if (shape->kind != SCENE_SHAPE_MESH) {
            visit(context, vec3_of(shape->centre), shape->radius);
            continue;
        }
        const float *p = scene->positions + 3 * (size_t)shape->first_vertex;
        for (uint32_t v = 0; v < shape->vertices; v++)
            visit(context, vec3_of(p + 3 * (size_t)v), 0);
    }
    if (scene->camera) {
        const double *m = scene->camera->to_world;
        double size2 = 0; /* at least the square of the matrix's largest stretch */
        for (int row = 0; row < 3; row++)
            for (int column = 0; column < 3; column++)
                size2 += m[4 * row + column] * m[4 * row + column];
        visit(context, vec3(m[3], m[7], m[11]), scene->camera->lens_radius * sqrt(size2));
    }
}

static void visit_box(void *context, vec3_t p, double radius)
{
    box_grow(context, p, radius);
}

static void visit_radius(void *context, vec3_t p, double radius)
{
    light_set_t *set = context;
    set->scene_radius = fmax(set->scene_radius, vec3_length(vec3_sub(p, set->centre)) + radius);
}

/* Around the middle of the bounding box. */
static void set_sphere(light_set_t *set, const scene_t *scene)
{
    box_t box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    visit_extent(scene, visit_box, &box);
    if (!(box.low.x <= box.high.x)) /* nothing at all */
        box = (box_t){{0, 0, 0}, {0, 0, 0}};
    set->centre = vec3_scale(vec3_add(box.low, box.high), 0.5);
    visit_extent(scene, visit_radius, set);
    set->scene_radius *= 1 + LIGHT_SPHERE_MARGIN;
    if (!(set->scene_radius > 0))
        set->scene_radius = 1;
}

/* ---- emitters, each with its power (zero: none) ---- */

static double triangle_emitter(const scene_t *scene, const scene_shape_t *shape, uint32_t primitive,
                               light_emitter_t *e)
{
    const uint32_t *corner = scene->indices + 3 * ((size_t)shape->first_triangle + primitive);
    const float *base = scene->positions + 3 * (size_t)shape->first_vertex;
    e->kind = LIGHT_TRIANGLE;
    e->position = vec3_of(base + 3 * (size_t)corner[0]);
    e->edge1 = vec3_sub(vec3_of(base + 3 * (size_t)corner[1]), e->position);
    e->edge2 = vec3_sub(vec3_of(base + 3 * (size_t)corner[2]), e->position);
    const vec3_t n = vec3_cross_exact(e->edge1, e->edge2);
    const double length = vec3_length(n);
    if (!(length > 0))
        return 0;
    e->normal = vec3_scale(n, (shape->flags & SCENE_SHAPE_FLIP ? -1 : 1) / length);
    e->area = 0.5 * length;
    return e->area;
}

static double round_emitter(const scene_shape_t *shape, light_emitter_t *e)
{
    e->position = vec3_of(shape->centre);
    e->radius = shape->radius;
    if (shape->kind == SCENE_SHAPE_SPHERE) {
        e->kind = LIGHT_SPHERE;
        e->flags |= shape->flags & SCENE_SHAPE_FLIP ? LIGHT_INWARD : 0;
        e->area = 4 * MATH_PI * e->radius * e->radius;
        return e->area;
    }
    e->kind = LIGHT_DISK;
    const vec3_t n = vec3_unit(vec3_of(shape->normal));
    const frame_t frame = frame_of_normal(n);
    e->edge1 = frame.s;
    e->edge2 = frame.t;
    e->normal = shape->flags & SCENE_SHAPE_FLIP ? vec3_neg(n) : n;
    e->area = MATH_PI * e->radius * e->radius;
    return e->area;
}

static double area_emitter(const scene_t *scene, uint32_t shape_index, uint32_t primitive, light_emitter_t *e)
{
    const scene_shape_t *shape = &scene->shapes[shape_index];
    const scene_light_t *light = &scene->lights[shape->area_light];
    memset(e, 0, sizeof *e);
    e->light = (uint32_t)shape->area_light;
    e->shape = shape_index;
    e->primitive = primitive;
    e->flags = light->two_sided ? LIGHT_TWO_SIDED : 0;
    e->radiance = rgb_of(light->radiance);
    const double area =
        shape->kind == SCENE_SHAPE_MESH ? triangle_emitter(scene, shape, primitive, e) : round_emitter(shape, e);
    return MATH_PI * area * rgb_luminance(e->radiance) * (light->two_sided ? 2 : 1);
}

/* The scene's rotation is in single precision: rows made orthogonal and unit in double, so that the transpose is
 * the inverse. */
static void set_rotation(const scene_light_t *light, light_emitter_t *e)
{
    const vec3_t x = vec3_of(light->to_light), y = vec3_of(light->to_light + 3), z = vec3_of(light->to_light + 6);
    e->edge1 = vec3_unit(x);
    e->edge2 = vec3_unit(vec3_mad(y, -vec3_dot(y, e->edge1), e->edge1));
    const vec3_t third = vec3_cross(e->edge1, e->edge2);
    e->normal = vec3_dot(third, z) < 0 ? vec3_neg(third) : third;
}

/* Fills the slot's table too. */
static fault_code_t infinite_emitter(const scene_t *scene, const scene_light_t *light, double disk_area,
                                     light_emitter_t *e, table2_t *table, double *power, fault_t *fault)
{
    e->kind = LIGHT_INFINITE;
    e->flags = LIGHT_AT_INFINITY;
    set_rotation(light, e);
    double mean = rgb_luminance(e->radiance);
    if (light->image != SCENE_NONE)
        TRY(environment_table(scene, &scene->images[light->image], e->radiance, table, &mean, fault));
    *power = 4 * MATH_PI * mean * disk_area;
    return FAULT_NONE;
}

static double distant_emitter(const scene_light_t *light, double disk_area, light_emitter_t *e)
{
    e->kind = LIGHT_DISTANT;
    e->flags = LIGHT_AT_INFINITY | LIGHT_DELTA_DIRECTION;
    e->normal = vec3_unit(vec3_of(light->direction));
    return rgb_luminance(e->radiance) * disk_area;
}

static double local_emitter(const scene_light_t *light, light_emitter_t *e)
{
    e->flags = LIGHT_DELTA_POSITION;
    e->position = vec3_of(light->position);
    if (light->kind == SCENE_LIGHT_POINT) {
        e->kind = LIGHT_POINT;
        return 4 * MATH_PI * rgb_luminance(e->radiance);
    }
    e->kind = LIGHT_SPOT;
    e->normal = vec3_unit(vec3_of(light->direction));
    e->cos_end = light->cos_end;
    e->cos_start = fmax(light->cos_start, light->cos_end);
    /* the smoothstep's integral over the rim is half the rim */
    return 2 * MATH_PI * rgb_luminance(e->radiance) * (1 - e->cos_start + 0.5 * (e->cos_start - e->cos_end));
}

/* ---- the set ---- */

static bool shape_emits(const scene_t *scene, const scene_shape_t *shape)
{
    if (shape->area_light == SCENE_NONE || !(rgb_luminance(rgb_of(scene->lights[shape->area_light].radiance)) > 0))
        return false;
    return shape->material == SCENE_NONE || scene->materials[shape->material].kind != SCENE_MATERIAL_INTERFACE;
}

static uint32_t shape_primitives(const scene_shape_t *shape)
{
    return shape->kind == SCENE_SHAPE_MESH ? shape->triangles : 1;
}

/* Room for every primitive of emitting shapes and every light. `weights` is the caller's to free. */
static fault_code_t allocate(light_set_t *set, const scene_t *scene, double **weights, fault_t *fault)
{
    uint64_t primitives = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (shape_emits(scene, &scene->shapes[i]))
            primitives += shape_primitives(&scene->shapes[i]);
    const uint64_t room = primitives + scene->light_count;
    if (room >= UINT32_MAX)
        return fault_set(fault, FAULT_LIMIT, "lights: %llu emitters, expected fewer than %u",
                         (unsigned long long)room, UINT32_MAX);
    set->emitters = calloc(room + 1, sizeof *set->emitters);
    set->first_of_shape = calloc((size_t)scene->shape_count + 1, sizeof *set->first_of_shape);
    set->emitter_of_primitive = calloc(primitives + 1, sizeof *set->emitter_of_primitive);
    set->infinite_tables = calloc(LIGHT_MAX_INFINITE, sizeof *set->infinite_tables);
    *weights = calloc(room + 1, sizeof **weights);
    if (!set->emitters || !set->first_of_shape || !set->emitter_of_primitive || !set->infinite_tables || !*weights)
        return fault_set(fault, FAULT_MEMORY, "lights: no memory for %llu emitters", (unsigned long long)room);
    return FAULT_NONE;
}

/* Keeps the emitter that stands at the end of the list. */
static uint32_t keep(light_set_t *set, double *weights, double power)
{
    const uint32_t flags = set->emitters[set->count].flags;
    weights[set->count] = power;
    set->has_infinite |= set->emitters[set->count].kind == LIGHT_INFINITE;
    set->has_delta |= (flags & (LIGHT_DELTA_POSITION | LIGHT_DELTA_DIRECTION)) != 0;
    set->can_hit |= (flags & (LIGHT_DELTA_POSITION | LIGHT_DELTA_DIRECTION)) == 0;
    return set->count++;
}

static void add_shapes(light_set_t *set, const scene_t *scene, double *weights)
{
    uint32_t next = 0;
    for (uint32_t i = 0; i < scene->shape_count; i++) {
        set->first_of_shape[i] = UINT32_MAX;
        if (!shape_emits(scene, &scene->shapes[i]))
            continue;
        set->first_of_shape[i] = next;
        for (uint32_t p = 0; p < shape_primitives(&scene->shapes[i]); p++) {
            const double power = area_emitter(scene, i, p, &set->emitters[set->count]);
            set->emitter_of_primitive[next++] = power > 0 ? keep(set, weights, power) : UINT32_MAX;
        }
    }
}

static fault_code_t add_infinite(light_set_t *set, const scene_t *scene, const scene_light_t *light,
                                 double disk_area, double *power, fault_t *fault)
{
    if (!(rgb_luminance(rgb_of(light->radiance)) > 0))
        return FAULT_NONE;
    if (set->infinite_count == LIGHT_MAX_INFINITE)
        return fault_set(fault, FAULT_LIMIT, "more than %d infinite lights", LIGHT_MAX_INFINITE);
    const uint32_t slot = (uint32_t)set->infinite_count;
    light_emitter_t *e = &set->emitters[set->count];
    e->primitive = slot;
    TRY(infinite_emitter(scene, light, disk_area, e, &set->infinite_tables[slot], power, fault));
    if (*power > 0) {
        set->infinite[slot] = set->count;
        set->infinite_count++;
    } else {
        table2_clear(&set->infinite_tables[slot]);
    }
    return FAULT_NONE;
}

static fault_code_t add_lights(light_set_t *set, const scene_t *scene, double *weights, fault_t *fault)
{
    const double disk_area = MATH_PI * set->scene_radius * set->scene_radius;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const scene_light_t *light = &scene->lights[i];
        light_emitter_t *e = &set->emitters[set->count];
        memset(e, 0, sizeof *e);
        e->light = i;
        e->radiance = rgb_of(light->radiance);
        double power = 0;
        switch (light->kind) {
        case SCENE_LIGHT_INFINITE:
            TRY(fault_prefix(fault, add_infinite(set, scene, light, disk_area, &power, fault), "light %u", i));
            break;
        case SCENE_LIGHT_DISTANT:
            power = distant_emitter(light, disk_area, e);
            break;
        case SCENE_LIGHT_POINT:
        case SCENE_LIGHT_SPOT:
            power = local_emitter(light, e);
            break;
        default: /* area lights: with their shapes */
            break;
        }
        if (power > 0)
            keep(set, weights, power);
    }
    return FAULT_NONE;
}

static fault_code_t fill(light_set_t *set, const scene_t *scene, double **weights, fault_t *fault)
{
    set_sphere(set, scene);
    TRY(allocate(set, scene, weights, fault));
    add_shapes(set, scene, *weights);
    TRY(add_lights(set, scene, *weights, fault));
    if (set->count == 0)
        return fault_set(
            fault, FAULT_NO_LIGHT,
            "the scene has no light: none of its %u lights has radiance and, if an area light, a shape",
            scene->light_count);
    TRY(fault_prefix(fault, table1_init(&set->selection, *weights, set->count, fault), "lights"));
    for (uint32_t i = 0; i < set->count; i++)
        set->emitters[i].probability = table1_probability(&set->selection, i);
    return FAULT_NONE;
}

fault_code_t light_set_init(light_set_t *set, const scene_t *scene, fault_t *fault)
{
    memset(set, 0, sizeof *set);
    double *weights = NULL;
    const fault_code_t code = fill(set, scene, &weights, fault);
    free(weights);
    if (code != FAULT_NONE)
        light_set_clear(set);
    return code;
}

void light_set_clear(light_set_t *set)
{
    for (int32_t i = 0; set->infinite_tables && i < LIGHT_MAX_INFINITE; i++)
        table2_clear(&set->infinite_tables[i]);
    free(set->infinite_tables);
    free(set->emitters);
    free(set->first_of_shape);
    free(set->emitter_of_primitive);
    table1_clear(&set->selection);
    memset(set, 0, sizeof *set);
}
