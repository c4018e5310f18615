#include "accel_fixture.h"

#include "math/frame.h"

accel_t *accel_of(const scene_t *scene)
{
    accel_t *accel = NULL;
    fault_t fault = {0};
    if (accel_new(&accel, scene, &fault))
        fail_msg("%s", fault.text);
    return accel;
}

vec3_t of_floats(const float *p)
{
    return vec3(p[0], p[1], p[2]);
}

vec3_t stream_point(stream_t *stream, double half)
{
    const double x = stream_number(stream), y = stream_number(stream), z = stream_number(stream);
    return vec3(half * (2 * x - 1), half * (2 * y - 1), half * (2 * z - 1));
}

vec3_t direction_at(stream_t *stream, vec3_t normal, double cosine)
{
    const frame_t frame = frame_of_normal(normal);
    const double phi = 2 * MATH_PI * stream_number(stream), sine = sqrt(1 - cosine * cosine);
    return frame_to_world(&frame, vec3(sine * cos(phi), sine * sin(phi), cosine));
}

const placement_t placements[PLACEMENTS] = {{1, 0}, {1e-6, 0}, {1e6, 0}, {1, 1e5}, {1e-6, 1e5}, {1e6, 1e5}};

static float placed(const placement_t *placement, double x, int axis)
{
    static const double towards[3] = {0.6, -0.64, 0.48};
    return (float)(placement->scale * (x + placement->shift * towards[axis]));
}

void closed_make(small_scene_t *closed, bool sphere, const placement_t *placement)
{
    static const float faces[] = {-1, -1, -1, 1,  -1, -1, 1,  -1, 1,  -1, -1, 1,  -1, 1,  -1, -1, 1,  1,
                                  1,  1,  1,  1,  1,  -1, -1, -1, -1, -1, 1,  -1, 1,  1,  -1, 1,  -1, -1,
                                  -1, -1, 1,  1,  -1, 1,  1,  1,  1,  -1, 1,  1,  -1, -1, -1, -1, -1, 1,
                                  -1, 1,  1,  -1, 1,  -1, 1,  -1, -1, 1,  1,  -1, 1,  1,  1,  1,  -1, 1};
    small_scene_begin(closed);
    const uint32_t grey = small_add_diffuse(closed, 0.5, 0.5, 0.5);
    float corners[72], centre[3];
    for (int i = 0; i < 72; i++)
        corners[i] = placed(placement, faces[i], i % 3);
    for (int i = 0; i < 3; i++)
        centre[i] = placed(placement, 0, i);
    if (sphere)
        small_add_sphere(closed, grey, centre, (float)placement->scale);
    else
        small_add_quads(closed, grey, SCENE_NONE, corners, 6);
    small_set_camera(closed, 0, 0, 0, 1);
    small_scene_finish(closed);
}

/* In single precision. Volatile: GCC 12.2 drops the conversions there and back where it has put two of them into
 * one vector. */
vec3_t placed_point(const placement_t *placement, vec3_t p)
{
    const volatile float x = placed(placement, p.x, 0), y = placed(placement, p.y, 1),
                         z = placed(placement, p.z, 2);
    return vec3((double)x, (double)y, (double)z);
}
