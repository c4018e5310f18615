#include "client/lab/charted_scene.h"

#include <math.h>
#include <stdbool.h>

#include "math/warp.h"

#define RISE 3.0 /* of light 1's radiance along y, by exponential */
#define RADIANCE1 0.5
#define RADIANCE2 10.0

/* exp(RISE) - 1 */
static double rise(void)
{
    return expm1(RISE);
}

/* The integral of the radiance over a light of unit area. */
static double power1(void)
{
    return RADIANCE1 * rise() / RISE;
}

static double power(void)
{
    return power1() + RADIANCE2;
}

/* Where light 1 ends and light 2 begins in number 2 of CHARTED_LIGHT. */
static double split(void)
{
    return power1() / power();
}

double charted_radiance(int light, double across)
{
    return light == 0 ? RADIANCE1 * exp(RISE * across) : RADIANCE2;
}

double charted_radiance_bound(void)
{
    return math_max(charted_radiance(0, 1), RADIANCE2);
}

rgb_t charted_colour(int light, double across)
{
    return light == 0 ? rgb(1, across, 1 - across) : rgb(0.1, 1, 0.1);
}

/* ---- paths ---- */

static double light_x(int light)
{
    return light == 0 ? 0 : CHARTED_LIGHT2_X;
}

static bool between(double lo, double value, double hi)
{
    return value >= lo && value <= hi;
}

/* The segment is always lower than the strip's upper edge. */
static bool behind_strip(const charted_path_t *path, double run)
{
    const double t = (CHARTED_STRIP_X - path->x) / run;
    return t > 0 && t < 1 && between(CHARTED_STRIP_Y0, path->y + t * (path->across - path->y), CHARTED_STRIP_Y1);
}

static bool through_hole(const charted_path_t *path, double run)
{
    const double t = (CHARTED_SCREEN_X - path->x) / run;
    return between(CHARTED_HOLE_Y0, path->y + t * (path->across - path->y), CHARTED_HOLE_Y1) &&
           between(CHARTED_HOLE_Z0, t * path->up, CHARTED_HOLE_Z1);
}

/* Visibility, target and densities of the two points. */
static charted_path_t path_of(double x, double y, int light, double across, double up)
{
    charted_path_t path = {.x = x, .y = y, .across = across, .up = up, .light = light};
    const double run = light_x(light) - x;
    if (behind_strip(&path, run) || (light == 1 && !through_hole(&path, run)))
        return path;
    const double square = run * run + (across - y) * (across - y) + up * up;
    const double geometric = up * fabs(run) / (square * square); /* cosines up / d and |run| / d */
    if (!(geometric > 0) || !isfinite(geometric))
        return path;
    const double radiance = charted_radiance(light, across);
    path.target = radiance * geometric * MATH_INV_PI;
    path.density[CHARTED_LIGHT] = radiance / power();
    path.density[CHARTED_DIRECTION] = geometric * MATH_INV_PI;
    return path;
}

/* ---- charts ---- */

static charted_path_t sample_light(const double u[CHARTED_NUMBERS])
{
    const double first = split();
    if (u[2] < first)
        return path_of(u[0], u[1], 0, math_min(log1p(u[2] / first * rise()) / RISE, 1), u[3]);
    return path_of(u[0], u[1], 1, (u[2] - first) / (1 - first), u[3]);
}

static void invert_light(const charted_path_t *path, double u[CHARTED_NUMBERS])
{
    const double first = split();
    if (path->light == 0)
        u[2] = math_min(first * (expm1(RISE * path->across) / rise()), nextafter(first, 0));
    else
        u[2] = math_min(first + (1 - first) * path->across, MATH_ONE_MINUS);
    u[3] = math_min(path->up, MATH_ONE_MINUS);
}

static charted_path_t sample_direction(const double u[CHARTED_NUMBERS])
{
    const vec3_t w = warp_cosine(u[2], u[3]);
    const int light = w.x < 0 ? 0 : 1;
    const double steps = (light_x(light) - u[0]) / w.x;
    const double across = u[1] + steps * w.y, up = steps * w.z;
    if (!(between(0, across, 1) && between(0, up, 1)))
        return (charted_path_t){.x = u[0], .y = u[1], .light = light};
    return path_of(u[0], u[1], light, across, up);
}

static void invert_direction(const charted_path_t *path, double u[CHARTED_NUMBERS])
{
    const vec3_t w = vec3(light_x(path->light) - path->x, path->across - path->y, path->up);
    warp_cosine_invert(vec3_unit(w), &u[2], &u[3]);
}

charted_path_t charted_sample(int chart, const double u[CHARTED_NUMBERS])
{
    return chart == CHARTED_LIGHT ? sample_light(u) : sample_direction(u);
}

void charted_invert(int chart, const charted_path_t *path, double u[CHARTED_NUMBERS])
{
    u[0] = path->x;
    u[1] = path->y;
    if (chart == CHARTED_LIGHT)
        invert_light(path, u);
    else
        invert_direction(path, u);
}
