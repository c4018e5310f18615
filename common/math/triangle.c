#include "math/triangle.h"

vec2_t triangle_coordinates(vec3_t e1, vec3_t e2, vec3_t p)
{
    const vec3_t n = vec3_cross_exact(e1, e2);
    const double scale = 1 / vec3_dot(n, n);
    return (vec2_t){vec3_dot(vec3_cross_exact(p, e2), n) * scale, vec3_dot(vec3_cross_exact(e1, p), n) * scale};
}

/* Along the edge from a by `edge` the place nearest to p, in [0,1]; its squared distance. */
static double nearest_on_edge(vec3_t p, vec3_t a, vec3_t edge, double *distance2)
{
    const vec3_t d = vec3_sub(p, a);
    const double t = fmin(fmax(vec3_dot(d, edge) / vec3_dot(edge, edge), 0), 1);
    const vec3_t off = vec3_mad(d, -t, edge);
    *distance2 = vec3_dot(off, off);
    return t;
}

vec2_t triangle_nearest(vec3_t e1, vec3_t e2, vec3_t p)
{
    const vec3_t origin = {0, 0, 0};
    double d1, d2, d3;
    const double t1 = nearest_on_edge(p, origin, e1, &d1), t2 = nearest_on_edge(p, origin, e2, &d2),
                 t3 = nearest_on_edge(p, e1, vec3_sub(e2, e1), &d3);
    if (d1 <= d2 && d1 <= d3)
        return (vec2_t){t1, 0};
    return d2 <= d3 ? (vec2_t){0, t2} : (vec2_t){1 - t3, t3};
}
