#include "path/recentre.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A coordinate is moved if its middle is further from zero than so many times the scene's half extent. Below that
 * vertices near zero would be rounded, beyond it all differences are exact (x > 3 r: a difference of at most
 * 2 r is less than 2^24 units of x's last place). */
#define FAR_AWAY 4.0

typedef struct box {
    double low[3], high[3];
} box_t;

static void box_grow(box_t *box, const float *p, double radius)
{
    for (int i = 0; i < 3; i++) {
        box->low[i] = fmin(box->low[i], (double)p[i] - radius);
        box->high[i] = fmax(box->high[i], (double)p[i] + radius);
    }
}

/* How far to move; false if nowhere. */
static bool shift_of(const scene_t *scene, const scene_camera_t *camera, double shift[3])
{
    const double *m = camera->to_world;
    box_t box = {{m[3], m[7], m[11]}, {m[3], m[7], m[11]}};
    for (uint64_t v = 0; v < scene->vertex_count; v++)
        box_grow(&box, scene->positions + 3 * v, 0);
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shapes[i].kind != SCENE_SHAPE_MESH)
            box_grow(&box, scene->shapes[i].centre, (double)scene->shapes[i].radius);
    double half = 0;
    for (int i = 0; i < 3; i++)
        half = fmax(half, 0.5 * (box.high[i] - box.low[i]));
    bool far = false;
    for (int i = 0; i < 3; i++) {
        const double middle = 0.5 * (box.high[i] + box.low[i]);
        shift[i] = 0;
        if (half > 0 && fabs(middle) > FAR_AWAY * half) {
            const double round = exp2(ceil(log2(half)));
            shift[i] = rint(middle / round) * round;
            far = true;
        }
    }
    return far;
}

static void move(float *p, const double shift[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = (float)((double)p[i] - shift[i]);
}

static void *copy_of(const void *array, uint64_t count, size_t size)
{
    void *copy = malloc((count + 1) * size);
    if (copy && count > 0)
        memcpy(copy, array, count * size);
    return copy;
}

fault_code_t path_recentre(path_recentred_t **out, const scene_t *scene, const scene_camera_t *camera,
                           fault_t *fault)
{
    double shift[3];
    *out = NULL;
    if (!shift_of(scene, camera, shift))
        return FAULT_NONE;
    path_recentred_t *moved = calloc(1, sizeof *moved);
    if (moved) {
        moved->positions = copy_of(scene->positions, 3 * scene->vertex_count, sizeof *moved->positions);
        moved->shapes = copy_of(scene->shapes, scene->shape_count, sizeof *moved->shapes);
        moved->lights = copy_of(scene->lights, scene->light_count, sizeof *moved->lights);
    }
    if (!moved || !moved->positions || !moved->shapes || !moved->lights) {
        path_recentred_destroy(&moved);
        return fault_set(fault, FAULT_MEMORY, "no memory to move %llu vertices to the origin",
                         (unsigned long long)scene->vertex_count);
    }
    for (uint64_t v = 0; v < scene->vertex_count; v++)
        move(moved->positions + 3 * v, shift);
    for (uint32_t i = 0; i < scene->shape_count; i++)
        if (scene->shapes[i].kind != SCENE_SHAPE_MESH)
            move(moved->shapes[i].centre, shift);
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].kind == SCENE_LIGHT_POINT || scene->lights[i].kind == SCENE_LIGHT_SPOT)
            move(moved->lights[i].position, shift);
    moved->camera = *camera;
    for (int i = 0; i < 3; i++)
        moved->camera.to_world[4 * i + 3] -= shift[i];
    moved->scene = *scene;
    moved->scene.positions = moved->positions;
    moved->scene.shapes = moved->shapes;
    moved->scene.lights = moved->lights;
    moved->scene.camera = &moved->camera;
    *out = moved;
    return FAULT_NONE;
}

void path_recentred_destroy(path_recentred_t **moved)
{
    if (!*moved)
        return;
    free((*moved)->positions);
    free((*moved)->shapes);
    free((*moved)->lights);
    free(*moved);
    *moved = NULL;
}
