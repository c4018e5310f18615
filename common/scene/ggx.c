#include "scene/ggx.h"

#include "math/warp.h"

static vec3_t stretched_unit(double au, double av, vec3_t wo)
{
    return vec3_unit(vec3(au * wo.x, av * wo.y, wo.z));
}

/* z = (1 - u2)(1 + w.z) - w.z is written through t = 1 - z = u2 (1 + w.z), so that sin^2 = t (2 - t) and
 * h.z = z + w.z = (1 - u2)(1 + w.z) keep their relative precision at both ends. */
vec3_t ggx_sample(double au, double av, vec3_t wo, double u1, double u2)
{
    const vec3_t w = stretched_unit(au, av, wo);
    const double t = u2 * (1 + w.z);
    const double r2 = t * (2 - t);
    const double r = r2 > 0 ? sqrt(r2) : 0;
    double sine, cosine;
    warp_sincos_turns(u1, &sine, &cosine);
    const vec3_t h = vec3(r * cosine + w.x, r * sine + w.y, (1 - u2) * (1 + w.z));
    return vec3_unit(vec3(au * h.x, av * h.y, h.z));
}

void ggx_invert(double au, double av, vec3_t wo, vec3_t m, double *u1, double *u2)
{
    const vec3_t w = stretched_unit(au, av, wo);
    const vec3_t h = vec3_unit(vec3(m.x / au, m.y / av, m.z));
    const double hw = vec3_dot(h, w);
    const vec3_t c = vec3(2 * hw * h.x - w.x, 2 * hw * h.y - w.y, 2 * hw * h.z - w.z);
    const double r2 = c.x * c.x + c.y * c.y;
    /* 1 - c.z, from the smaller of the two expressions */
    const double t = c.z > 0 ? r2 / (1 + c.z) : 1 + w.z - 2 * hw * h.z;
    *u2 = warp_clamp_unit(t / (1 + w.z));
    *u1 = warp_turns(c.y, c.x);
}
