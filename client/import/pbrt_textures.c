#include "client/import/pbrt_textures.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "client/import/picture.h"
#include "client/import/stored_file.h"

/* Colours beyond this are taken for mistakes. */
#define LARGEST_VALUE 1e30
/* Sodium's yellow line, where indices of refraction are quoted, in nm. */
#define SODIUM_LINE 589.3

enum { SPECTRUM_FILE_PAIRS = 100000 };

/* ---- constant colours ---- */

/* A file of wavelengths and values; pairs are the caller's to free(). */
static fault_code_t read_spectrum(pbrt_state_t *state, const char *name, double **pairs, size_t *count)
{
    char path[PBRT_PATH_MAX];
    uint8_t *data;
    size_t size;
    pbrt_lexer_t lexer;
    pbrt_token_t token;
    fault_code_t code = FAULT_NONE;
    if (pbrt_resolve(state, name, path))
        return pbrt_fault(state, FAULT_UNKNOWN, "\"%s\" is neither a known spectrum nor a file", name);
    TRY(stored_file_read(path, &data, &size, state->fault));
    double *values = malloc(2 * SPECTRUM_FILE_PAIRS * sizeof *values);
    size_t n = 0;
    if (!values)
        code = pbrt_fault(state, FAULT_MEMORY, "no memory for a spectrum");
    pbrt_lexer_init(&lexer, (const char *)data, size);
    while (code == FAULT_NONE) {
        code = pbrt_lexer_next(&lexer, &token, state->fault);
        if (code || token.kind == PBRT_END)
            break;
        if (n == 2 * SPECTRUM_FILE_PAIRS || !pbrt_token_number(&token, &values[n]))
            code = pbrt_fault(state, FAULT_FORMAT, "%s:%d: expected at most %d numbers", path, token.line,
                              2 * SPECTRUM_FILE_PAIRS);
        n++;
    }
    if (code == FAULT_NONE && (n % 2 != 0 || !spectra_pairs_valid(values, n / 2)))
        code = pbrt_fault(state, FAULT_FORMAT,
                          "%s: expected pairs of a wavelength and a value, wavelengths increasing", path);
    free(data);
    if (code) {
        free(values);
        return code;
    }
    *pairs = values;
    *count = n / 2;
    return FAULT_NONE;
}

static fault_code_t check_color(pbrt_params_t *params, const pbrt_param_t *param, rgb_t c, fault_t *fault)
{
    if (c.r >= 0 && c.g >= 0 && c.b >= 0 && rgb_max(c) <= LARGEST_VALUE)
        return FAULT_NONE;
    return pbrt_params_fault(params, param, fault, FAULT_RANGE, "found (%g, %g, %g), expected values of 0 to %g",
                             c.r, c.g, c.b, LARGEST_VALUE);
}

static fault_code_t named_spectrum(pbrt_state_t *state, const char *name, spectra_use_t use, rgb_t *value)
{
    double *pairs;
    size_t count;
    if (spectra_named(name, use, value))
        return FAULT_NONE;
    TRY(read_spectrum(state, name, &pairs, &count));
    *value = spectra_of_pairs(pairs, count, use);
    free(pairs);
    return FAULT_NONE;
}

static fault_code_t color_of(pbrt_state_t *state, pbrt_params_t *params, const pbrt_param_t *param,
                             spectra_use_t use, rgb_t *value)
{
    const double *n = param->numbers;
    if (!(param->type == PBRT_SPECTRUM && n) && param->count != (param->type == PBRT_RGB ? 3 : 1))
        return pbrt_params_fault(params, param, state->fault, FAULT_FORMAT, "found %zu values, expected one %s",
                                 param->count, pbrt_type_name(param->type));
    if (param->type == PBRT_RGB) {
        *value = rgb(n[0], n[1], n[2]);
    } else if (param->type == PBRT_BLACKBODY) {
        if (!(n[0] >= 100 && n[0] <= 1e6))
            return pbrt_params_fault(params, param, state->fault, FAULT_RANGE, "found %g K, expected 100 to 1e6 K",
                                     n[0]);
        *value = spectra_blackbody(n[0], use);
    } else if (n) {
        if (!spectra_pairs_valid(n, param->count / 2))
            return pbrt_params_fault(params, param, state->fault, FAULT_FORMAT,
                                     "expected pairs of a wavelength and a value, wavelengths increasing");
        *value = spectra_of_pairs(n, param->count / 2, use);
    } else {
        TRY(named_spectrum(state, param->strings[0], use, value));
    }
    return check_color(params, param, *value, state->fault);
}

fault_code_t pbrt_color(pbrt_state_t *state, pbrt_params_t *params, const char *name, spectra_use_t use,
                        rgb_t *value, bool *given)
{
    const pbrt_param_t *param;
    PBRT_TRY(state, params,
             pbrt_params_typed(params, name,
                               PBRT_MASK(PBRT_RGB) | PBRT_MASK(PBRT_SPECTRUM) | PBRT_MASK(PBRT_BLACKBODY), &param,
                               state->fault));
    *given = param != NULL;
    return param ? pbrt_at_params(state, params, color_of(state, params, param, use, value)) : FAULT_NONE;
}

fault_code_t pbrt_index_of_refraction(pbrt_state_t *state, pbrt_params_t *params, const char *name, double *value)
{
    const pbrt_param_t *param;
    PBRT_TRY(state, params,
             pbrt_params_typed(params, name, PBRT_MASK(PBRT_FLOAT) | PBRT_MASK(PBRT_SPECTRUM) | PBRT_MASK(PBRT_RGB),
                               &param, state->fault));
    rgb_t color = {0, 0, 0};
    if (!param)
        return FAULT_NONE;
    if (param->type == PBRT_FLOAT && param->count == 1) {
        *value = param->numbers[0];
    } else if (param->type == PBRT_SPECTRUM && param->numbers) {
        PBRT_TRY(state, params, color_of(state, params, param, SPECTRA_UNBOUNDED, &color));
        *value = spectra_pairs_at(param->numbers, param->count / 2, SODIUM_LINE);
    } else {
        PBRT_TRY(state, params, color_of(state, params, param, SPECTRA_UNBOUNDED, &color));
        *value = color.g;
    }
    if (!(*value > 0 && *value <= 1000))
        return pbrt_at_params(state, params,
                              pbrt_params_fault(params, param, state->fault, FAULT_RANGE,
                                                "found %g, expected an index of refraction", *value));
    return FAULT_NONE;
}

/* ---- parameters that may be textures ---- */

static void set_constant(scene_param_t *out, rgb_t c)
{
    *out = (scene_param_t){{(float)c.r, (float)c.g, (float)c.b}, SCENE_NONE};
}

static fault_code_t named_texture(pbrt_state_t *state, pbrt_params_t *params, const pbrt_param_t *param,
                                  const name_table_t *table, const char *type, scene_param_t *out)
{
    if (param->count != 1)
        return pbrt_params_fault(params, param, state->fault, FAULT_FORMAT, "found %zu values, expected 1",
                                 param->count);
    const int32_t index = name_table_get(table, param->strings[0], -1);
    if (index < 0)
        return pbrt_params_fault(params, param, state->fault, FAULT_UNKNOWN,
                                 "there is no %s texture \"%s\" before this line", type, param->strings[0]);
    const scene_texture_t *texture = &state->texture_list[index];
    set_constant(out, rgb(1, 1, 1));
    if (texture->kind == SCENE_TEXTURE_CONSTANT)
        memcpy(out->value, texture->value, sizeof out->value);
    else
        out->texture = index;
    return FAULT_NONE;
}

/* A colour of any size, or a texture: operands of textures. */
static fault_code_t open_color(pbrt_state_t *state, pbrt_params_t *params, const char *name, spectra_use_t use,
                               double absent, scene_param_t *out, bool *given)
{
    const pbrt_param_t *param;
    rgb_t value = rgb_gray(absent);
    PBRT_TRY(state, params,
             pbrt_params_typed(params, name,
                               PBRT_MASK(PBRT_RGB) | PBRT_MASK(PBRT_SPECTRUM) | PBRT_MASK(PBRT_BLACKBODY) |
                                   PBRT_MASK(PBRT_TEXTURE),
                               &param, state->fault));
    *given = param != NULL;
    if (param && param->type == PBRT_TEXTURE)
        return pbrt_at_params(state, params,
                              named_texture(state, params, param, &state->color_textures, "spectrum", out));
    if (param)
        PBRT_TRY(state, params, color_of(state, params, param, use, &value));
    set_constant(out, value);
    return FAULT_NONE;
}

static fault_code_t open_scalar(pbrt_state_t *state, pbrt_params_t *params, const char *name, double absent,
                                scene_param_t *out, bool *given)
{
    const pbrt_param_t *param;
    double value = absent;
    PBRT_TRY(
        state, params,
        pbrt_params_typed(params, name, PBRT_MASK(PBRT_FLOAT) | PBRT_MASK(PBRT_TEXTURE), &param, state->fault));
    *given = param != NULL;
    if (param && param->type == PBRT_TEXTURE)
        return pbrt_at_params(state, params,
                              named_texture(state, params, param, &state->scalar_textures, "float", out));
    PBRT_TRY(state, params, pbrt_params_float(params, name, 0, LARGEST_VALUE, &value, state->fault));
    set_constant(out, rgb_gray(value));
    return FAULT_NONE;
}

static void cut_to_one(pbrt_state_t *state, pbrt_params_t *params, const char *name, scene_param_t *out)
{
    for (int i = 0; i < 3; i++)
        if (out->value[i] > 1) {
            pbrt_note(state, "parameter \"%s\" of %s is %g: cut to 1", name, params->what, (double)out->value[i]);
            out->value[i] = 1;
        }
}

fault_code_t pbrt_color_param(pbrt_state_t *state, pbrt_params_t *params, const char *name, double absent,
                              scene_param_t *out, bool *given)
{
    TRY(open_color(state, params, name, SPECTRA_REFLECTANCE, absent, out, given));
    cut_to_one(state, params, name, out);
    return FAULT_NONE;
}

fault_code_t pbrt_scalar_param(pbrt_state_t *state, pbrt_params_t *params, const char *name, double absent,
                               scene_param_t *out, bool *given)
{
    TRY(open_scalar(state, params, name, absent, out, given));
    cut_to_one(state, params, name, out);
    return FAULT_NONE;
}

/* ---- textures ---- */

typedef struct texture_maker {
    scene_texture_t texture;
    bool color; /* "spectrum", else "float" */
} texture_maker_t;

static fault_code_t operand(pbrt_state_t *state, pbrt_params_t *params, bool color, const char *name, double absent,
                            scene_param_t *out)
{
    bool given;
    return color ? open_color(state, params, name, SPECTRA_UNBOUNDED, absent, out, &given)
                 : open_scalar(state, params, name, absent, out, &given);
}

static fault_code_t read_mapping(pbrt_state_t *state, pbrt_params_t *params, scene_texture_t *t)
{
    const char *mapping = "uv";
    double su = 1, sv = 1, du = 0, dv = 0;
    const double most = 1e15;
    PBRT_TRY(state, params, pbrt_params_string(params, "mapping", &mapping, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "uscale", -most, most, &su, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "vscale", -most, most, &sv, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "udelta", -most, most, &du, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "vdelta", -most, most, &dv, state->fault));
    pbrt_params_ignore(params, "v1");
    pbrt_params_ignore(params, "v2");
    if (strcmp(mapping, "uv") != 0)
        pbrt_note(state, "texture mapping \"%s\" is not supported: \"uv\" is used", mapping);
    t->scale_u = (float)su;
    t->scale_v = (float)sv;
    t->offset_u = (float)du;
    t->offset_v = (float)dv;
    return FAULT_NONE;
}

static fault_code_t read_coding(pbrt_state_t *state, pbrt_params_t *params, picture_coding_t *coding)
{
    const char *text = "sRGB";
    char *end;
    *coding = (picture_coding_t){PICTURE_CODING_SRGB, 1};
    PBRT_TRY(state, params, pbrt_params_string(params, "encoding", &text, state->fault));
    if (strcmp(text, "sRGB") == 0)
        return FAULT_NONE;
    if (strcmp(text, "linear") == 0) {
        coding->kind = PICTURE_CODING_LINEAR;
        return FAULT_NONE;
    }
    if (strncmp(text, "gamma ", 6) == 0) {
        coding->kind = PICTURE_CODING_GAMMA;
        coding->gamma = strtod(text + 6, &end);
        if (end != text + 6 && *end == 0 && coding->gamma > 0 && coding->gamma <= 100)
            return FAULT_NONE;
    }
    return pbrt_fault(state, FAULT_UNKNOWN, "encoding \"%s\": expected \"sRGB\", \"linear\" or \"gamma G\"", text);
}

static fault_code_t add_image(pbrt_state_t *state, picture_t *image, uint32_t *index)
{
    float *samples = image->texels;
    const size_t count = image->bytes / sizeof *samples;
    for (size_t i = 0; image->texel == SCENE_TEXEL_FLOAT32 && i < count; i++)
        if (samples[i] < 0) {
            pbrt_note(state, "an image has texels below zero: they are set to zero");
            for (; i < count; i++)
                samples[i] = samples[i] < 0 ? 0 : samples[i];
        }
    const scene_image_t record = {0, image->width, image->height, image->channels, image->texel};
    return scene_builder_add_image(state->builder, &record, image->texels, index, state->fault);
}

/* The image of that file and coding, read once. */
static fault_code_t load_image(pbrt_state_t *state, const char *name, picture_coding_t coding,
                               pbrt_loaded_image_t *out)
{
    char path[PBRT_PATH_MAX], key[PBRT_PATH_MAX + 32];
    picture_t image;
    TRY(pbrt_resolve(state, name, path));
    snprintf(key, sizeof key, "%d %g %s", (int)coding.kind, coding.gamma, path);
    const int32_t known = name_table_get(&state->images, key, -1);
    if (known >= 0) {
        *out = state->image_list[known];
        return FAULT_NONE;
    }
    TRY(picture_read(path, coding, &image, state->fault));
    out->channels = image.channels;
    out->opaque = image.opaque;
    const fault_code_t code = add_image(state, &image, &out->index);
    picture_clear(&image);
    TRY(code);
    pbrt_loaded_image_t *list = pbrt_grown(state->image_list, state->image_count, sizeof *list);
    if (!list)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for an image's name");
    state->image_list = list;
    list[state->image_count] = *out;
    return name_table_set(&state->images, key, (int32_t)state->image_count++, state->fault);
}

static fault_code_t make_image(pbrt_state_t *state, pbrt_params_t *params, texture_maker_t *m)
{
    const char *filename = NULL, *wrap = "repeat";
    double scale = 1;
    bool invert = false;
    picture_coding_t coding;
    pbrt_loaded_image_t image;
    PBRT_TRY(state, params, pbrt_params_string(params, "filename", &filename, state->fault));
    PBRT_TRY(state, params, pbrt_params_string(params, "wrap", &wrap, state->fault));
    PBRT_TRY(state, params, pbrt_params_float(params, "scale", 0, LARGEST_VALUE, &scale, state->fault));
    PBRT_TRY(state, params, pbrt_params_bool(params, "invert", &invert, state->fault));
    TRY(read_coding(state, params, &coding));
    TRY(read_mapping(state, params, &m->texture));
    pbrt_params_ignore(params, "filter");
    pbrt_params_ignore(params, "maxanisotropy");
    if (!filename)
        return pbrt_fault(state, FAULT_FORMAT, "an imagemap without a \"filename\"");
    if (strcmp(wrap, "black") == 0)
        m->texture.wrap = SCENE_WRAP_BLACK;
    else if (strcmp(wrap, "clamp") == 0)
        m->texture.wrap = SCENE_WRAP_CLAMP;
    else if (strcmp(wrap, "repeat") != 0)
        pbrt_note(state, "wrap mode \"%s\" is not supported: \"repeat\" is used", wrap);
    TRY(load_image(state, filename, coding, &image));
    m->texture.kind = SCENE_TEXTURE_IMAGE;
    m->texture.image = (int32_t)image.index;
    m->texture.invert = invert;
    m->texture.alpha_channel = !m->color && image.channels == 4 && !image.opaque;
    for (int i = 0; i < 3; i++)
        m->texture.value[i] = (float)scale;
    return FAULT_NONE;
}

static fault_code_t make_constant(pbrt_state_t *state, pbrt_params_t *params, texture_maker_t *m)
{
    scene_param_t value;
    TRY(operand(state, params, m->color, "value", 1, &value));
    if (value.texture >= 0)
        return pbrt_fault(state, FAULT_TYPE, "the value of a constant texture is a texture");
    memcpy(m->texture.value, value.value, sizeof value.value);
    return FAULT_NONE;
}

static fault_code_t make_scale(pbrt_state_t *state, pbrt_params_t *params, texture_maker_t *m)
{
    bool given;
    m->texture.kind = SCENE_TEXTURE_SCALE;
    TRY(operand(state, params, m->color, "tex", 1, &m->texture.a));
    return open_scalar(state, params, "scale", 1, &m->texture.b, &given);
}

static fault_code_t make_mix(pbrt_state_t *state, pbrt_params_t *params, texture_maker_t *m)
{
    bool given;
    m->texture.kind = SCENE_TEXTURE_MIX;
    TRY(operand(state, params, m->color, "tex1", 0, &m->texture.a));
    TRY(operand(state, params, m->color, "tex2", 1, &m->texture.b));
    return open_scalar(state, params, "amount", 0.5, &m->texture.m, &given);
}

/* A value halfway for what is not supported. */
static void make_middle(texture_maker_t *m)
{
    m->texture.kind = SCENE_TEXTURE_CONSTANT;
    for (int i = 0; i < 3; i++)
        m->texture.value[i] = 0.5f;
}

static void use_all(pbrt_params_t *params)
{
    for (size_t i = 0; i < params->count; i++)
        params->items[i].used = true;
}

static fault_code_t make_checkerboard(pbrt_state_t *state, pbrt_params_t *params, texture_maker_t *m)
{
    int dimension = 2;
    PBRT_TRY(state, params, pbrt_params_int(params, "dimension", 2, 3, &dimension, state->fault));
    if (dimension == 3) {
        pbrt_note(state, "checkerboards of dimension 3 are not supported: the constant 0.5 is used");
        make_middle(m);
        use_all(params);
        return FAULT_NONE;
    }
    m->texture.kind = SCENE_TEXTURE_CHECKERBOARD;
    TRY(operand(state, params, m->color, "tex1", 1, &m->texture.a));
    TRY(operand(state, params, m->color, "tex2", 0, &m->texture.b));
    return read_mapping(state, params, &m->texture);
}

static fault_code_t make_texture(pbrt_state_t *state, const char *kind, pbrt_params_t *params, texture_maker_t *m)
{
    if (strcmp(kind, "imagemap") == 0)
        return make_image(state, params, m);
    if (strcmp(kind, "constant") == 0)
        return make_constant(state, params, m);
    if (strcmp(kind, "scale") == 0)
        return make_scale(state, params, m);
    if (strcmp(kind, "mix") == 0)
        return make_mix(state, params, m);
    if (strcmp(kind, "checkerboard") == 0)
        return make_checkerboard(state, params, m);
    pbrt_note(state, "textures of the kind \"%s\" are not supported: the constant 0.5 is used", kind);
    make_middle(m);
    use_all(params);
    return FAULT_NONE;
}

/* An operation on constants is a constant. */
static void fold(scene_texture_t *t)
{
    if (t->a.texture >= 0 || t->b.texture >= 0 || t->m.texture >= 0)
        return;
    for (int i = 0; i < 3; i++) {
        const double a = (double)t->a.value[i], b = (double)t->b.value[i], m = (double)t->m.value[0];
        if (t->kind == SCENE_TEXTURE_SCALE)
            t->value[i] = (float)fmin((double)t->value[i] * a * b, LARGEST_VALUE);
        else if (t->kind == SCENE_TEXTURE_MIX)
            t->value[i] = (float)fmin(fmax(a * (1 - m) + b * m, 0), LARGEST_VALUE);
    }
    if (t->kind == SCENE_TEXTURE_SCALE || t->kind == SCENE_TEXTURE_MIX)
        t->kind = SCENE_TEXTURE_CONSTANT;
}

fault_code_t pbrt_texture(pbrt_state_t *state, const char *name, const char *type, const char *kind,
                          pbrt_params_t *params)
{
    const scene_param_t none = {{0, 0, 0}, SCENE_NONE};
    texture_maker_t m = {.texture = {.kind = SCENE_TEXTURE_CONSTANT,
                                     .image = SCENE_NONE,
                                     .scale_u = 1,
                                     .scale_v = 1,
                                     .value = {1, 1, 1},
                                     .a = none,
                                     .b = none,
                                     .m = none},
                         .color = strcmp(type, "spectrum") == 0};
    uint32_t index;
    if (!m.color && strcmp(type, "float") != 0)
        return pbrt_fault(state, FAULT_TYPE, "Texture \"%s\": the type \"%s\", expected \"float\" or \"spectrum\"",
                          name, type);
    TRY(make_texture(state, kind, params, &m));
    fold(&m.texture);
    TRY(scene_builder_add_texture(state->builder, &m.texture, &index, state->fault));
    scene_texture_t *list = pbrt_grown(state->texture_list, state->texture_count, sizeof *list);
    if (!list)
        return pbrt_fault(state, FAULT_MEMORY, "no memory for a texture's name");
    state->texture_list = list;
    list[state->texture_count++] = m.texture;
    return name_table_set(m.color ? &state->color_textures : &state->scalar_textures, name, (int32_t)index,
                          state->fault);
}
