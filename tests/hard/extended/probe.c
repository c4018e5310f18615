/* probe.c: the lists as one, and the maps of common/math. Compiled with either build; PROBE_BUILD is its name. */
#include "probe_list.h"

#include "math/frame.h"
#include "math/warp.h"

#define PROBE_JOINED(name, build) name##build
#define PROBE_NAMED(name, build) PROBE_JOINED(name, build)
#define PROBE_INFO PROBE_NAMED(probe_info_, PROBE_BUILD)
#define PROBE_RUN PROBE_NAMED(probe_run_, PROBE_BUILD)

static const probe_t *find(uint32_t which)
{
    const probe_t *const lists[] = {probe_maps, probe_scattering, probe_coats, probe_places, probe_lights};
    for (int i = 0; i < 5; i++)
        for (const probe_t *p = lists[i]; p->info.name; p++)
            if (which-- == 0)
                return p;
    return NULL;
}

__attribute__((visibility("default"))) const probe_info_t *PROBE_INFO(uint32_t which)
{
    const probe_t *probe = find(which);
    return probe ? &probe->info : NULL;
}

__attribute__((visibility("default"))) bool PROBE_RUN(uint32_t which, const probe_number_t *in, probe_number_t *out)
{
    const probe_t *probe = find(which);
    double numbers[PROBE_MAX_INPUTS], results[PROBE_MAX_OUTPUTS] = {0};
    for (int i = 0; i < PROBE_MAX_INPUTS; i++)
        numbers[i] = (double)in[i];
    if (!probe->run(numbers, results))
        return false;
    for (int i = 0; i < PROBE_MAX_OUTPUTS; i++)
        out[i] = results[i];
    return true;
}

/* ---- maps ---- */

static bool run_turns(const double *in, double *out)
{
    warp_sincos_turns(in[0], &out[0], &out[1]);
    return true;
}

static bool run_disk(const double *in, double *out)
{
    const vec2_t p = warp_disk(in[0], in[1]);
    out[0] = p.x;
    out[1] = p.y;
    return true;
}

static bool run_disk_invert(const double *in, double *out)
{
    warp_disk_invert((vec2_t){in[0], in[1]}, &out[0], &out[1]);
    return true;
}

static bool run_cosine(const double *in, double *out)
{
    const vec3_t w = warp_cosine(in[0], in[1]);
    probe_put(out, w);
    out[3] = w.z * MATH_INV_PI;
    return true;
}

static bool run_cosine_invert(const double *in, double *out)
{
    warp_cosine_invert(probe_vec(in), &out[0], &out[1]);
    return true;
}

static bool run_sphere(const double *in, double *out)
{
    probe_put(out, warp_sphere(in[0], in[1]));
    return true;
}

static bool run_sphere_invert(const double *in, double *out)
{
    warp_sphere_invert(probe_vec(in), &out[0], &out[1]);
    return true;
}

/* A cosine serves as 1 - cos of a cone, down to 1e-9. */
static bool run_cone(const double *in, double *out)
{
    const vec3_t w = warp_cone(in[0], in[1], in[2]);
    probe_put(out, w);
    out[3] = w.x;
    out[4] = w.y;
    return true;
}

static bool run_cone_invert(const double *in, double *out)
{
    warp_cone_invert(probe_vec(in), 1, &out[0], &out[1]);
    return true;
}

static bool run_triangle(const double *in, double *out)
{
    const vec2_t b = warp_triangle(in[0], in[1]);
    out[0] = b.x;
    out[1] = b.y;
    return true;
}

static bool run_triangle_invert(const double *in, double *out)
{
    warp_triangle_invert((vec2_t){in[0] * in[1], in[0] * (1 - in[1])}, &out[0], &out[1]);
    return true;
}

static bool run_octahedral(const double *in, double *out)
{
    probe_put(out, warp_octahedral(in[0], in[1]));
    return true;
}

static bool run_octahedral_invert(const double *in, double *out)
{
    warp_octahedral_invert(probe_vec(in), &out[0], &out[1]);
    return true;
}

static bool run_frame(const double *in, double *out)
{
    const frame_t frame = frame_of_normal(probe_vec(in));
    probe_put(out, frame_to_world(&frame, probe_vec(in + 3)));
    probe_put(out + 3, frame_to_local(&frame, probe_vec(in + 3)));
    return true;
}

const probe_t probe_maps[] = {
    {{"sine and cosine of turns", "u", {{"pair", 2, 0}}, 0}, run_turns},
    {{"disk", "uu", {{"place", 2, 0}}, 0}, run_disk},
    {{"disk, inverse", "w", {{"radius", 1, 0}, {"turn", 1, 0}}, 0}, run_disk_invert},
    {{"cosine hemisphere", "uu", {{"direction", 3, 0}, {"density", 1, 0}}, 0}, run_cosine},
    {{"cosine hemisphere, inverse", "w", {{"u1", 1, 0}, {"u2", 1, 0}}, 0}, run_cosine_invert},
    {{"sphere", "uu", {{"direction", 3, 0}}, 0}, run_sphere},
    {{"sphere, inverse", "d", {{"u1", 1, 0}, {"u2", 1, 0}}, 0}, run_sphere_invert},
    {{"cone", "uuc", {{"direction", 3, 0}, {"off the axis", 2, 0}}, 0}, run_cone},
    {{"cone, inverse", "w", {{"u1", 1, 0}, {"u2", 1, 0}}, 0}, run_cone_invert},
    {{"triangle", "uu", {{"b1", 1, 0}, {"b2", 1, 0}}, 0}, run_triangle},
    {{"triangle, inverse", "uu", {{"u1", 1, 0}, {"u2", 1, 0}}, 0}, run_triangle_invert},
    {{"octahedral map", "uu", {{"direction", 3, 0}}, 0}, run_octahedral},
    {{"octahedral map, inverse", "d", {{"x", 1, 1}, {"y", 1, 1}}, 0}, run_octahedral_invert},
    {{"frame", "dd", {{"to world", 3, 0}, {"to local", 3, 0}}, 0}, run_frame},
    {{NULL, NULL, {{NULL, 0, 0}}, 0}, NULL},
};
