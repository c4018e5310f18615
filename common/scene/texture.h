/* texture.h: parameter look-up. Inline for the constants, which most are. */
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
    return __builtin_expect(p->texture < 0, 1) ? p->value[0] : p->value[0] * texture_scalar(scene, p->texture, u, v);
}

#endif
