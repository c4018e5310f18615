/* texture.h: parameter look-up. Inline for the constants, which most are.
 *
 * The kinds of scene.h, (u,v) the surface's coordinates, (u',v') = (scale_u u + offset_u, scale_v v + offset_v):
 *   constant      value
 *   image         value * texel(u',v'), or 1 minus that if `invert`; never below 0. v' = 0 is the bottom row's
 * lower edge; four texels are filtered bilinearly, centres at half-integers; wrap says what lies beyond the image:
 * its repetition, black, or its edge scale         value * a * b checkerboard  a where floor(u') + floor(v') is
 * even, else b mix           a (1 - m) + b m, m a scalar Operands are looked up at (u,v) itself. A scalar uses
 * value[0] and, of an image, the mean of the linear colour channels, or the fourth channel where alpha_channel is
 * set.
 *
 * Hot calls: nothing is checked, scene_check has seen to indices, depth and magnitudes. Any u, v is allowed, also
 * one that is not finite (the result is then some value of the texture). Pure; any thread.
 */
#ifndef SCENE_TEXTURE_H
#define SCENE_TEXTURE_H

#include "math/vec.h"
#include "scene/scene.h"

/* The texture's colour, or its scalar, at (u,v); texture must not be SCENE_NONE. Images are filtered bilinearly. */
rgb_t texture_color(const scene_t *scene, int32_t texture, double u, double v);
double texture_scalar(const scene_t *scene, int32_t texture, double u, double v);

static inline rgb_t texture_param_color(const scene_t *scene, const scene_param_t *p, double u, double v)
{
    const rgb_t value = {p->value[0], p->value[1], p->value[2]};
    return __builtin_expect(p->texture < 0, 1) ? value : rgb_mul(value, texture_color(scene, p->texture, u, v));
}

static inline double texture_param_scalar(const scene_t *scene, const scene_param_t *p, double u, double v)
{
    return __builtin_expect(p->texture < 0, 1) ? p->value[0]
                                               : p->value[0] * texture_scalar(scene, p->texture, u, v);
}

#endif
