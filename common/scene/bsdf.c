#include "scene/bsdf.h"

#include "scene/bsdf_coat.h"
#include "scene/bsdf_lobes.h"

/* Each lobe of a mixture is taken with at least 1 / (64 + count) of the walks: an estimate that is wrong by a
 * factor then costs noise, not fireflies. */
static const double SELECT_FLOOR = 1.0 / 64;

static inline bool lobe_has_coat(const bsdf_lobe_t *lobe)
{
    return lobe->kind == BSDF_COATED_BASE || lobe->kind == BSDF_COATED_CONDUCTOR || lobe->kind == BSDF_COAT ||
           lobe->kind == BSDF_MIRROR_COAT;
}

static inline bool lobe_is_coat(const bsdf_lobe_t *lobe)
{
    return lobe->kind == BSDF_COAT || lobe->kind == BSDF_MIRROR_COAT;
}

/* The probabilities alpha_l(w) and the coats' albedos, for w.z > 0. Lobes under one coat follow one another, so
 * that each coat is looked up once. */
static void shares_of(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t w, bsdf_share_t *shares)
{
    const bsdf_lobe_t *last = NULL;
    double albedo = 0, through = 1, sum = 0;
    for (uint32_t l = 0; l < bsdf->count; l++) {
        const bsdf_lobe_t *lobe = &bsdf->lobes[l];
        double select = lobe->select;
        shares[l].coat = 0;
        shares[l].through = 1;
        if (lobe_has_coat(lobe)) {
            if (!last || last->coat != lobe->coat || last->coat_row != lobe->coat_row)
                albedo = bsdf_coat_albedo(&tables->coats[lobe->coat], w, lobe->coat_row, &through);
            last = lobe;
            shares[l].coat = albedo;
            shares[l].through = through;
            select *= lobe_is_coat(lobe) ? albedo : through;
        }
        shares[l].probability = select;
        sum += select;
    }
    if (bsdf->count == 1) {
        shares[0].probability = 1;
        return;
    }
    /* grazing light on a coat over nothing can leave a sum of zero: any choice will do */
    const double floor = sum > 0 ? sum * SELECT_FLOOR : 1;
    const double scale = 1 / (sum + bsdf->count * floor);
    for (uint32_t l = 0; l < bsdf->count; l++)
        shares[l].probability = (shares[l].probability + floor) * scale;
}

/* The smooth mixture in the flipped frame. */
static void mixture_eval(const bsdf_t *bsdf, double eta_sign, vec3_t wo, vec3_t wi, const bsdf_share_t *so,
                         const bsdf_share_t *si, bsdf_mode_t mode, bsdf_value_t *out)
{
    *out = (bsdf_value_t){{0, 0, 0}, 0, 0};
    for (uint32_t l = 0; l < bsdf->count; l++) {
        const bsdf_lobe_t *lobe = &bsdf->lobes[l];
        if (BSDF_KIND_IS_SPECULAR(lobe->kind))
            continue;
        bsdf_value_t v;
        const double eta = eta_sign > 0 ? lobe->eta : 1 / lobe->eta;
        bsdf_lobe_eval(lobe, eta, wo, wi, so[l].through, si[l].through, mode, &v);
        out->f = rgb_add(out->f, v.f);
        out->pdf += so[l].probability * v.pdf;
        out->pdf_reverse += si[l].probability * v.pdf_reverse;
    }
}

void bsdf_eval_mixture(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, bsdf_mode_t mode,
                       bsdf_value_t *out)
{
    if (!(bsdf->flags & BSDF_HAS_SMOOTH) || wo.z == 0 || wi.z == 0) {
        *out = (bsdf_value_t){{0, 0, 0}, 0, 0};
        return;
    }
    const double sign = copysign(1, wo.z);
    wo.z *= sign;
    wi.z *= sign;
    bsdf_share_t so[BSDF_MAX_LOBES], si[BSDF_MAX_LOBES];
    shares_of(bsdf, tables, wo, so);
    shares_of(bsdf, tables, vec3(wi.x, wi.y, fabs(wi.z)), si);
    mixture_eval(bsdf, sign, wo, wi, so, si, mode, out);
}

static bool sample_specular(const bsdf_t *bsdf, const bsdf_tables_t *tables, uint32_t l, double sign, vec3_t wo,
                            double rest, double probability, bsdf_mode_t mode, bsdf_sample_t *out)
{
    const bsdf_lobe_t *lobe = &bsdf->lobes[l];
    const double eta = sign > 0 ? lobe->eta : 1 / lobe->eta;
    double g;
    const double reflects = bsdf_lobe_reflects(lobe, eta, wo, &g);
    const bool transmitted = rest >= reflects;
    bsdf_specular_t event;
    bsdf_lobe_specular(lobe, eta, wo, reflects, g, transmitted, mode, &event);
    if (!(event.probability > 0) || event.wi.z == 0)
        return false;
    double reverse = 1;
    if (bsdf->count > 1) {
        bsdf_share_t si[BSDF_MAX_LOBES];
        shares_of(bsdf, tables, vec3(event.wi.x, event.wi.y, fabs(event.wi.z)), si);
        reverse = si[l].probability;
    }
    out->wi = vec3(event.wi.x, event.wi.y, event.wi.z * sign);
    out->pdf = probability * event.probability;
    out->pdf_reverse = reverse * event.probability;
    out->weight = rgb_scale(event.coefficient, 1 / out->pdf);
    out->eta = event.eta;
    out->lobe = l;
    out->specular = true;
    out->transmitted = transmitted;
    return true;
}

/* The lobe whose interval holds u, and u's place in it. Lobes' intervals follow one another in their order. */
static uint32_t choose_lobe(const bsdf_t *bsdf, const bsdf_share_t *shares, double u, double *rest)
{
    uint32_t l = 0;
    double begin = 0;
    while (l + 1 < bsdf->count && u >= begin + shares[l].probability) {
        begin += shares[l].probability;
        l++;
    }
    *rest = warp_clamp_unit((u - begin) / shares[l].probability);
    return l;
}

bool bsdf_sample_mixture(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, const double u[3],
                         bsdf_mode_t mode, bsdf_sample_t *out)
{
    if (bsdf->count == 0 || wo.z == 0)
        return false;
    const double sign = copysign(1, wo.z);
    wo.z *= sign;
    if (bsdf->count == 1 && BSDF_KIND_IS_SPECULAR(bsdf->lobes[0].kind))
        return sample_specular(bsdf, tables, 0, sign, wo, u[0], 1, mode, out);
    bsdf_share_t so[BSDF_MAX_LOBES], si[BSDF_MAX_LOBES];
    shares_of(bsdf, tables, wo, so);
    double rest;
    const uint32_t l = choose_lobe(bsdf, so, u[0], &rest);
    const bsdf_lobe_t *lobe = &bsdf->lobes[l];
    if (BSDF_KIND_IS_SPECULAR(lobe->kind))
        return sample_specular(bsdf, tables, l, sign, wo, rest, so[l].probability, mode, out);
    const double eta = sign > 0 ? lobe->eta : 1 / lobe->eta;
    vec3_t wi;
    if (!bsdf_lobe_sample(lobe, eta, wo, rest, u + 1, &wi))
        return false;
    shares_of(bsdf, tables, vec3(wi.x, wi.y, fabs(wi.z)), si);
    bsdf_value_t value;
    mixture_eval(bsdf, sign, wo, wi, so, si, mode, &value);
    if (!(value.pdf > 0) || !(value.pdf <= 0x1p1000))
        return false;
    out->wi = vec3(wi.x, wi.y, wi.z * sign);
    out->weight = rgb_scale(value.f, fabs(wi.z) / value.pdf);
    out->pdf = value.pdf;
    out->pdf_reverse = value.pdf_reverse;
    out->transmitted = wi.z < 0;
    out->eta = lobe->kind == BSDF_DIELECTRIC && out->transmitted ? eta : 1;
    out->lobe = l;
    out->specular = false;
    return true;
}

/* ---- inverse ---- */

/* u[0] for the place `rest` in the interval of lobe l: strictly inside it. */
static double place_in_lobe(const bsdf_share_t *shares, uint32_t l, double rest)
{
    double begin = 0;
    for (uint32_t i = 0; i < l; i++)
        begin += shares[i].probability;
    const double end = begin + shares[l].probability;
    const double u = begin + rest * shares[l].probability;
    return warp_clamp_unit(u < end ? u : fmax(nextafter(end, 0), begin));
}

static bool invert_specular(const bsdf_t *bsdf, uint32_t l, double sign, vec3_t wo, vec3_t wi,
                            const bsdf_share_t *so, const double free_numbers[3], double u[3])
{
    if (l >= bsdf->count || !BSDF_KIND_IS_SPECULAR(bsdf->lobes[l].kind))
        return false;
    const bsdf_lobe_t *lobe = &bsdf->lobes[l];
    double g;
    const double reflects = bsdf_lobe_reflects(lobe, sign > 0 ? lobe->eta : 1 / lobe->eta, wo, &g);
    const double begin = wi.z < 0 ? reflects : 0, end = wi.z < 0 ? 1 : reflects;
    if (!(end > begin))
        return false;
    const double rest = begin + free_numbers[0] * (end - begin);
    u[0] = place_in_lobe(so, l, rest < end ? rest : fmax(nextafter(end, 0), begin));
    u[1] = free_numbers[1];
    u[2] = free_numbers[2];
    return true;
}

/* The smooth lobe that made wi, drawn by alpha_l p_l; what is left of the number stays uniform. */
static bool draw_lobe(const bsdf_t *bsdf, double sign, vec3_t wo, vec3_t wi, const bsdf_share_t *so,
                      bsdf_mode_t mode, double *number, uint32_t *drawn)
{
    double density[BSDF_MAX_LOBES], sum = 0;
    for (uint32_t l = 0; l < bsdf->count; l++) {
        const bsdf_lobe_t *lobe = &bsdf->lobes[l];
        density[l] = 0;
        if (BSDF_KIND_IS_SPECULAR(lobe->kind))
            continue;
        bsdf_value_t v;
        bsdf_lobe_eval(lobe, sign > 0 ? lobe->eta : 1 / lobe->eta, wo, wi, 0, 0, mode, &v);
        density[l] = so[l].probability * v.pdf;
        sum += density[l];
    }
    if (!(sum > 0))
        return false;
    double x = *number * sum;
    uint32_t last = UINT32_MAX;
    for (uint32_t l = 0; l < bsdf->count; l++) {
        if (!(density[l] > 0))
            continue;
        last = l;
        if (x < density[l])
            break;
        x -= density[l];
    }
    *number = warp_clamp_unit(x / density[last]);
    *drawn = last;
    return true;
}

bool bsdf_invert(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, bool specular,
                 uint32_t lobe, bsdf_mode_t mode, const double free_numbers[3], double u[3])
{
    if (bsdf->count == 0 || wo.z == 0 || wi.z == 0)
        return false;
    const double sign = copysign(1, wo.z);
    wo.z *= sign;
    wi.z *= sign;
    bsdf_share_t so[BSDF_MAX_LOBES];
    shares_of(bsdf, tables, wo, so);
    if (specular)
        return invert_specular(bsdf, lobe, sign, wo, wi, so, free_numbers, u);
    double number = free_numbers[0], rest;
    uint32_t l;
    if (!draw_lobe(bsdf, sign, wo, wi, so, mode, &number, &l))
        return false;
    const bsdf_lobe_t *from = &bsdf->lobes[l];
    bsdf_lobe_invert(from, sign > 0 ? from->eta : 1 / from->eta, wo, wi, number, &rest, u + 1);
    u[0] = place_in_lobe(so, l, rest);
    return true;
}

/* ---- albedo ---- */

static rgb_t lobe_albedo(const bsdf_lobe_t *lobe, const bsdf_share_t *share, double z)
{
    switch (lobe->kind) {
    case BSDF_COATED_BASE: /* color is rho / (eta^2 (1 - rho Fi)) and Tbar at most 1 */
        return rgb_scale(lobe->color, share->through);
    case BSDF_CONDUCTOR:
    case BSDF_MIRROR_CONDUCTOR:
        return rgb_mul(lobe->color, fresnel_conductor(z, lobe->eta3, lobe->k3));
    case BSDF_COATED_CONDUCTOR:
        return rgb_mul(lobe->color, rgb_scale(bsdf_coated_fresnel(lobe, z), share->through));
    case BSDF_MIRROR_COATED_CONDUCTOR:
        return rgb_mul(lobe->color,
                       bsdf_coated_mirror(fresnel_dielectric(z, lobe->eta), bsdf_coated_fresnel(lobe, z)));
    case BSDF_COAT:
    case BSDF_MIRROR_COAT:
        return rgb_scale(lobe->color, share->coat);
    default:
        return lobe->color;
    }
}

rgb_t bsdf_albedo(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo)
{
    const vec3_t w = vec3(wo.x, wo.y, fabs(wo.z));
    bsdf_share_t shares[BSDF_MAX_LOBES];
    shares_of(bsdf, tables, w, shares);
    rgb_t sum = {0, 0, 0};
    for (uint32_t l = 0; l < bsdf->count; l++) {
        const bsdf_lobe_t *lobe = &bsdf->lobes[l];
        rgb_t a = lobe_albedo(lobe, &shares[l], w.z);
        if (lobe->kind == BSDF_COATED_BASE)
            a = rgb_scale(a, tables->coats[lobe->coat].eta * tables->coats[lobe->coat].eta *
                                 (1 - bsdf_coat_inner(&tables->coats[lobe->coat], lobe->coat_row)));
        sum = rgb_add(sum, a);
    }
    return rgb(fmin(sum.r, 1), fmin(sum.g, 1), fmin(sum.b, 1));
}
