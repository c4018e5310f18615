#include "chain/stuck.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "path/walk.h"

bool stuck_is(uint64_t stay, uint64_t accepted, uint64_t steps)
{
    if (stay < STUCK_LEAST || steps < STUCK_LEAST)
        return false;
    double chance = 1;
    for (uint64_t i = 0; i < stay && chance >= STUCK_CHANCE; i++)
        chance *= 1 - (double)(accepted + 1) / (double)(steps + 2 + i);
    return chance < STUCK_CHANCE;
}

void stuck_add_light(stuck_t *stuck, double light)
{
    const double scaled = light * STUCK_LIGHT_ONE;
    stuck->light = stuck_sum_light(stuck->light, scaled < 0x1p63 ? (uint64_t)(scaled + 0.5) : UINT64_MAX);
}

/* ---- paths ---- */

/* Vertex i of the path, from the light on. */
static const path_vertex_t *stuck_vertex(const path_space_t *space, uint32_t length, uint32_t s, uint32_t i)
{
    return i < s ? &space->light[i] : &space->camera[length - i];
}

/* The lobe that the path scatters with: where two walks meet, the one of the smooth that is chosen most often. */
static const bsdf_lobe_t *stuck_lobe(const path_vertex_t *v, bool joined)
{
    const bsdf_lobe_t *lobe = NULL;
    if (!v->bsdf)
        return NULL;
    if (!joined && v->lobe < v->bsdf->count)
        return &v->bsdf->lobes[v->lobe];
    for (uint32_t i = 0; i < v->bsdf->count; i++) {
        const bsdf_lobe_t *other = &v->bsdf->lobes[i];
        if (!BSDF_KIND_IS_SPECULAR(other->kind) && (!lobe || other->select > lobe->select))
            lobe = other;
    }
    return lobe;
}

/* Which side of v's surface the path comes from or goes to at its neighbour `to`. */
static double stuck_side(const path_vertex_t *v, const path_vertex_t *to)
{
    return vec3_dot(v->ng, to->kind == PATH_INFINITE ? to->ng : vec3_sub(to->position, v->position));
}

void stuck_encode(const path_space_t *space, uint32_t length, uint32_t s, uint8_t codes[STUCK_MAX_INNER])
{
    static_assert(STUCK_MAX_INNER == PATH_MAX_LENGTH - 1, "a code for each vertex between light and lens");
    memset(codes, 0, STUCK_MAX_INNER);
    for (uint32_t i = 1; i < length; i++) {
        const path_vertex_t *v = stuck_vertex(space, length, s, i);
        const bsdf_lobe_t *lobe = stuck_lobe(v, s > 0 && (i + 1 == s || i == s));
        uint8_t code = STUCK_DIFFUSE;
        if (lobe && BSDF_KIND_IS_SPECULAR(lobe->kind))
            code = STUCK_SPECULAR;
        else if (lobe && lobe->kind >= BSDF_CONDUCTOR)
            code = STUCK_GLOSSY;
        if (stuck_side(v, stuck_vertex(space, length, s, i - 1)) *
                stuck_side(v, stuck_vertex(space, length, s, i + 1)) <
            0)
            code += STUCK_DIFFUSE_THROUGH;
        codes[i - 1] = code;
    }
}

/* ---- the longest ---- */

/* Whether a goes before b. Of one chain the earlier stay does, which only one unit knows: the order in which they
 * come. */
static bool stuck_before(const stuck_path_t *a, const stuck_path_t *b)
{
    if (a->stay != b->stay)
        return a->stay > b->stay;
    return a->length != b->length ? a->length < b->length : a->chain < b->chain;
}

void stuck_keep(stuck_t *stuck, const stuck_path_t *path)
{
    uint32_t at = stuck->count;
    while (at > 0 && stuck_before(path, &stuck->paths[at - 1]))
        at--;
    if (at == STUCK_PATHS)
        return;
    if (stuck->count < STUCK_PATHS)
        stuck->count++;
    memmove(stuck->paths + at + 1, stuck->paths + at, sizeof *stuck->paths * (stuck->count - at - 1));
    stuck->paths[at] = *path;
}

void stuck_add(stuck_t *to, const stuck_t *from)
{
    to->stays += from->stays;
    to->rejections += from->rejections;
    to->light = stuck_sum_light(to->light, from->light);
    for (uint32_t i = 0; i < from->count; i++)
        stuck_keep(to, &from->paths[i]);
}

void stuck_print(const stuck_path_t *path, char text[STUCK_TEXT])
{
    static const char *const names[STUCK_CODES] = {"D", "G", "S", "Dt", "Gt", "St"};
    int at =
        snprintf(text, STUCK_TEXT, "length %u, technique %u, pixel (%.0f, %.0f), %llu rejections: L", path->length,
                 path->technique, floor(path->x), floor(path->y), (unsigned long long)path->stay);
    for (uint32_t i = 0; i + 1 < path->length; i++)
        at += snprintf(text + at, STUCK_TEXT - (size_t)at, " %s", names[path->codes[i]]);
    snprintf(text + at, STUCK_TEXT - (size_t)at, " E");
}

/* ---- as bytes ---- */

void stuck_put(wire_writer_t *out, const stuck_t *stuck)
{
    wire_put_u64(out, stuck->stays);
    wire_put_u64(out, stuck->rejections);
    wire_put_u64(out, stuck->light);
    wire_put_u32(out, stuck->count);
    for (uint32_t i = 0; i < stuck->count; i++) {
        const stuck_path_t *path = &stuck->paths[i];
        wire_put_u32(out, path->length);
        wire_put_u32(out, path->technique);
        wire_put_u64(out, path->stay);
        wire_put_u64(out, path->chain);
        wire_put_f64(out, path->x);
        wire_put_f64(out, path->y);
        wire_put_f64(out, path->c);
        wire_put_raw(out, path->codes, path->length - 1);
    }
}

static fault_code_t stuck_get_path(wire_reader_t *in, stuck_path_t *path, uint32_t max_length)
{
    path->length = wire_get_u32(in, "stuck length");
    path->technique = wire_get_u32(in, "stuck technique");
    path->stay = wire_get_u64(in, "stay");
    path->chain = wire_get_u64(in, "stuck chain");
    path->x = wire_get_f64(in, "stuck x");
    path->y = wire_get_f64(in, "stuck y");
    path->c = wire_get_f64(in, "stuck c");
    if (in->code)
        return in->code;
    if (path->length < 1 || path->length > max_length || path->technique > path->length)
        return wire_reader_fail(in, FAULT_RANGE, "stuck length", "%u by technique %u, expected 1 to %u",
                                path->length, path->technique, max_length);
    if (path->stay < STUCK_LEAST)
        return wire_reader_fail(in, FAULT_RANGE, "stay", "%llu, expected %d or more",
                                (unsigned long long)path->stay, STUCK_LEAST);
    if (!(fabs(path->x) < 1e6 && fabs(path->y) < 1e6))
        return wire_reader_fail(in, FAULT_RANGE, "stuck x", "(%g, %g) is not on a film", path->x, path->y);
    if (!(path->c > 0) || !isfinite(path->c))
        return wire_reader_fail(in, FAULT_RANGE, "stuck c", "%g, expected more than 0", path->c);
    const uint8_t *codes = wire_get_raw(in, "stuck codes", path->length - 1);
    if (!codes)
        return in->code;
    for (uint32_t i = 0; i + 1 < path->length; i++) {
        if (codes[i] >= STUCK_CODES)
            return wire_reader_fail(in, FAULT_RANGE, "stuck codes", "%u, expected less than %d", codes[i],
                                    STUCK_CODES);
        path->codes[i] = codes[i];
    }
    return FAULT_NONE;
}

fault_code_t stuck_get(wire_reader_t *in, stuck_t *stuck, uint32_t max_length)
{
    *stuck = (stuck_t){.stays = wire_get_u64(in, "stuck stays")};
    stuck->rejections = wire_get_u64(in, "stuck rejections");
    stuck->light = wire_get_u64(in, "stuck light");
    const uint32_t count = wire_get_u32(in, "stuck paths");
    if (in->code)
        return in->code;
    if (stuck->stays > stuck->rejections / STUCK_LEAST)
        return wire_reader_fail(in, FAULT_RANGE, "stuck stays", "%llu, of %llu rejections",
                                (unsigned long long)stuck->stays, (unsigned long long)stuck->rejections);
    if (stuck->light > 0 && stuck->stays == 0)
        return wire_reader_fail(in, FAULT_RANGE, "stuck light", "%llu of no stay",
                                (unsigned long long)stuck->light);
    if (count != (stuck->stays < STUCK_PATHS ? stuck->stays : STUCK_PATHS))
        return wire_reader_fail(in, FAULT_FORMAT, "stuck paths", "%u of %llu, at most %d are kept", count,
                                (unsigned long long)stuck->stays, STUCK_PATHS);
    uint64_t left = stuck->rejections;
    for (; stuck->count < count; stuck->count++) {
        stuck_path_t *path = &stuck->paths[stuck->count];
        TRY(stuck_get_path(in, path, max_length));
        if (path->stay > left || (stuck->count > 0 && stuck_before(path, path - 1)))
            return wire_reader_fail(in, FAULT_FORMAT, "stay", "%llu rejections are out of order or too many",
                                    (unsigned long long)path->stay);
        left -= path->stay;
    }
    if (stuck->stays <= STUCK_PATHS && left > 0)
        return wire_reader_fail(in, FAULT_FORMAT, "stuck rejections", "%llu are in no stay",
                                (unsigned long long)left);
    return FAULT_NONE;
}
