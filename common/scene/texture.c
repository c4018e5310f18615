#include "scene/texture.h"

#include "scene/texel.h"

/* ---- bilinear look-up ---- */

typedef struct tap {
    uint32_t x, y;
    double weight;
} tap_t;

/* The two texels along one axis around coordinate t (in [0,1] across the image) and the weight of the second. A
 * texel outside in the black wrap mode has the index -1. */
static void axis_taps(double t, uint32_t size, uint32_t wrap, int32_t taps[2], double *fraction)
{
    const int32_t n = (int32_t)size;
    if (wrap == SCENE_WRAP_REPEAT)
        t -= floor(t);
    /* Texel centres are at k + 1/2. Clamped in floating point: the conversion is defined for any number, NaN too.
     */
    const double x = fmin(fmax(t * size - 0.5, -2.0), size + 1.0);
    const double low = floor(x);
    *fraction = x - low;
    taps[0] = (int32_t)low;
    taps[1] = taps[0] + 1;
    for (int i = 0; i < 2; i++) {
        if (taps[i] >= 0 && taps[i] < n)
            continue;
        if (wrap == SCENE_WRAP_REPEAT)
            taps[i] = taps[i] < 0 ? n - 1 : 0;
        else if (wrap == SCENE_WRAP_CLAMP)
            taps[i] = taps[i] < 0 ? 0 : n - 1;
        else
            taps[i] = -1;
    }
}

/* The four texels around (u,v); returns how many count. Row 0 is the top of the image, where v = 1. */
static int image_taps(const scene_image_t *image, const scene_texture_t *texture, double u, double v, tap_t taps[4])
{
    int32_t xs[2], ys[2];
    double fx, fy;
    int count = 0;
    axis_taps((double)texture->scale_u * u + (double)texture->offset_u, image->width, texture->wrap, xs, &fx);
    axis_taps(1.0 - ((double)texture->scale_v * v + (double)texture->offset_v), image->height, texture->wrap, ys,
              &fy);
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++)
            if (xs[i] >= 0 && ys[j] >= 0)
                taps[count++] =
                    (tap_t){(uint32_t)xs[i], (uint32_t)ys[j], (i ? fx : 1.0 - fx) * (j ? fy : 1.0 - fy)};
    return count;
}

static double image_channel(const scene_t *scene, const scene_image_t *image, const tap_t *taps, int count,
                            uint32_t c)
{
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += taps[i].weight * texel_channel(scene, image, taps[i].x, taps[i].y, c);
    return sum;
}

static double inverted(const scene_texture_t *texture, double value)
{
    return fmax(texture->invert ? 1.0 - value : value, 0.0);
}

static rgb_t image_color(const scene_t *scene, const scene_texture_t *texture, double u, double v)
{
    const scene_image_t *image = &scene->images[texture->image];
    tap_t taps[4];
    const int count = image_taps(image, texture, u, v, taps);
    const double r = image_channel(scene, image, taps, count, 0);
    const bool gray = image->channels == 1;
    const double g = gray ? r : image_channel(scene, image, taps, count, 1);
    const double b = gray ? r : image_channel(scene, image, taps, count, 2);
    return rgb(inverted(texture, texture->value[0] * r), inverted(texture, texture->value[1] * g),
               inverted(texture, texture->value[2] * b));
}

static double image_scalar(const scene_t *scene, const scene_texture_t *texture, double u, double v)
{
    const scene_image_t *image = &scene->images[texture->image];
    tap_t taps[4];
    const int count = image_taps(image, texture, u, v, taps);
    const uint32_t first = texture->alpha_channel ? 3 : 0;
    const uint32_t channels = texture->alpha_channel || image->channels == 1 ? 1 : 3;
    double sum = 0;
    for (uint32_t c = 0; c < channels; c++)
        sum += image_channel(scene, image, taps, count, first + c);
    return inverted(texture, texture->value[0] * (sum / channels));
}

/* ---- the kinds ---- */

/* The operand of the square of the checkerboard that (u,v) is in. */
static const scene_param_t *checkerboard_operand(const scene_texture_t *texture, double u, double v)
{
    const double squares = floor((double)texture->scale_u * u + (double)texture->offset_u) +
                           floor((double)texture->scale_v * v + (double)texture->offset_v);
    return fmod(squares, 2.0) == 0 ? &texture->a : &texture->b;
}

rgb_t texture_color(const scene_t *scene, int32_t index, double u, double v)
{
    const scene_texture_t *t = &scene->textures[index];
    switch (t->kind) {
    case SCENE_TEXTURE_IMAGE:
        return image_color(scene, t, u, v);
    case SCENE_TEXTURE_SCALE:
        return rgb_mul(rgb(t->value[0], t->value[1], t->value[2]),
                       rgb_mul(texture_param_color(scene, &t->a, u, v), texture_param_color(scene, &t->b, u, v)));
    case SCENE_TEXTURE_CHECKERBOARD:
        return texture_param_color(scene, checkerboard_operand(t, u, v), u, v);
    case SCENE_TEXTURE_MIX: {
        const double m = texture_param_scalar(scene, &t->m, u, v);
        return rgb_mad(rgb_scale(texture_param_color(scene, &t->a, u, v), 1.0 - m), m,
                       texture_param_color(scene, &t->b, u, v));
    }
    default:
        return rgb(t->value[0], t->value[1], t->value[2]);
    }
}

double texture_scalar(const scene_t *scene, int32_t index, double u, double v)
{
    const scene_texture_t *t = &scene->textures[index];
    switch (t->kind) {
    case SCENE_TEXTURE_IMAGE:
        return image_scalar(scene, t, u, v);
    case SCENE_TEXTURE_SCALE:
        return t->value[0] * texture_param_scalar(scene, &t->a, u, v) * texture_param_scalar(scene, &t->b, u, v);
    case SCENE_TEXTURE_CHECKERBOARD:
        return texture_param_scalar(scene, checkerboard_operand(t, u, v), u, v);
    case SCENE_TEXTURE_MIX: {
        const double m = texture_param_scalar(scene, &t->m, u, v);
        return texture_param_scalar(scene, &t->a, u, v) * (1.0 - m) + texture_param_scalar(scene, &t->b, u, v) * m;
    }
    default:
        return t->value[0];
    }
}
