#include "scene/bsdf_lobes.h"

#include "scene/fresnel.h"
#include "scene/ggx.h"

static const bsdf_value_t NOTHING;

/* Without fmin's care for NaN, which costs a call. */
static inline double smaller(double a, double b)
{
    return a < b ? a : b;
}

static inline double larger(double a, double b)
{
    return a > b ? a : b;
}

rgb_t bsdf_coated_fresnel(const bsdf_lobe_t *lobe, double c)
{
    const double s = 1 / lobe->eta;
    const double inside2 = 1 - (1 - c) * (1 + c) * s * s;
    return fresnel_conductor(inside2 > 0 ? sqrt(inside2) : 0, lobe->eta3, lobe->k3);
}

static double coated_mirror1(double f, double c)
{
    const double t = 1 - f, loss = 1 - f * c;
    return loss > 0 ? f + t * t * c / loss : 1;
}

rgb_t bsdf_coated_mirror(double coat, rgb_t conductor)
{
    return rgb(coated_mirror1(coat, conductor.r), coated_mirror1(coat, conductor.g),
               coated_mirror1(coat, conductor.b));
}

/* T(o) T(i) C / (1 - min(E(o), E(i)) C): symmetric, exact where o and i are mirror directions of smooth surfaces,
 * and never more than T(o) (docs/materials.md). */
static double coated_conductor1(double both, double most, double c)
{
    const double loss = 1 - c + most * c; /* 1 - min(E) C */
    return loss > 0 ? both * c / loss : 0;
}

static rgb_t coated_conductor(const bsdf_lobe_t *lobe, double cosine, double through_o, double through_i)
{
    const rgb_t c = bsdf_coated_fresnel(lobe, cosine);
    const double both = through_o * through_i, most = larger(through_o, through_i);
    return rgb(coated_conductor1(both, most, c.r), coated_conductor1(both, most, c.g),
               coated_conductor1(both, most, c.b));
}

/* ---- refraction ---- */

/* The microfacet that refracts wo into wi, from wo + eta wi = h: m = +-h / |h| (Walter et al. 2007, eq. 16), with
 * wo.m > 0 > wi.m. False where no facet seen from both sides does. */
typedef struct refraction {
    vec3_t m;
    double h2; /* |wo + eta wi|^2 = (wo.m + eta wi.m)^2 */
    double om, im;
} refraction_t;

static bool refraction_of(double eta, vec3_t wo, vec3_t wi, refraction_t *out)
{
    /* wo + eta wi, with the small difference eta - 1 apart */
    const vec3_t h = vec3_mad(vec3_add(wo, wi), eta - 1, wi);
    const double h2 = vec3_dot(h, h);
    if (!(h2 > 0))
        return false;
    const double scale = copysign(1 / sqrt(h2), h.z);
    out->m = vec3_scale(h, scale);
    out->h2 = h2;
    out->om = vec3_dot(wo, out->m);
    out->im = vec3_dot(wi, out->m);
    out->om = smaller(out->om, 1);
    out->im = out->im > -1 ? out->im : -1;
    return out->om > 0 && out->im < 0 && out->m.z > 0;
}

/* X = D (1 - F) |wo.m| |wi.m| / |h|^2:  f (radiance) = X G2 / (o.z i.z), f (importance) = eta^2 that (Walter et al.
 * 2007, eq. 21; Veach 1997, eq. 5.14), pdf = 2 eta^2 X / (o.z + L_o), reverse 2 X / (i.z + L_i) (ibid., eq. 17 and
 * 24 with visible normals). */
static void refract_eval(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, bsdf_mode_t mode,
                         bsdf_value_t *out)
{
    refraction_t r;
    *out = NOTHING;
    if (!refraction_of(eta, wo, wi, &r))
        return;
    const double au = lobe->alpha_u, av = lobe->alpha_v, iz = -wi.z;
    /* each cosine times its index is the other side's g: nothing cancels near total reflection */
    const double through = fresnel_dielectric_t(r.om, eta, -r.im * eta);
    const double x = ggx_d(au, av, r.m, 1) * through * r.om * -r.im / r.h2;
    const double lo = ggx_stretch(au, av, wo), li = ggx_stretch(au, av, wi);
    const double eta2 = eta * eta;
    const double f = 2 * x / (lo * iz + li * wo.z) * (mode == BSDF_IMPORTANCE ? eta2 : 1);
    out->f = rgb_scale(lobe->color, f);
    out->pdf = 2 * eta2 * x / (wo.z + lo);
    out->pdf_reverse = 2 * x / (iz + li);
}

static void dielectric_eval(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, bsdf_mode_t mode,
                            bsdf_value_t *out)
{
    if (wi.z < 0) {
        refract_eval(lobe, eta, wo, wi, mode, out);
        return;
    }
    const ggx_reflection_t g = ggx_reflect(lobe->alpha_u, lobe->alpha_v, wo, wi);
    const double f = fresnel_dielectric(g.cosine, eta);
    *out = (bsdf_value_t){rgb_scale(lobe->color, f * g.f), f * g.pdf, f * g.pdf_reverse};
}

/* ---- value ---- */

static void lambert_eval(rgb_t color, double zo, double zi, bsdf_value_t *out)
{
    *out = (bsdf_value_t){rgb_scale(color, MATH_INV_PI), zi * MATH_INV_PI, zo * MATH_INV_PI};
}

void bsdf_lobe_eval(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, double through_o, double through_i,
                    bsdf_mode_t mode, bsdf_value_t *out)
{
    if (lobe->kind == BSDF_DIELECTRIC && wi.z != 0) {
        dielectric_eval(lobe, eta, wo, wi, mode, out);
        return;
    }
    if (lobe->kind == BSDF_DIFFUSE_TRANSMIT && wi.z < 0) {
        lambert_eval(lobe->color, wo.z, -wi.z, out);
        return;
    }
    if (!(wi.z > 0) || lobe->kind == BSDF_DIFFUSE_TRANSMIT) {
        *out = NOTHING;
        return;
    }
    if (lobe->kind == BSDF_DIFFUSE) {
        lambert_eval(lobe->color, wo.z, wi.z, out);
        return;
    }
    if (lobe->kind == BSDF_COATED_BASE) {
        lambert_eval(rgb_scale(lobe->color, through_o * through_i), wo.z, wi.z, out);
        return;
    }
    const ggx_reflection_t g = ggx_reflect(lobe->alpha_u, lobe->alpha_v, wo, wi);
    const rgb_t fresnel = lobe->kind == BSDF_CONDUCTOR ? fresnel_conductor(g.cosine, lobe->eta3, lobe->k3)
                          : lobe->kind == BSDF_COAT    ? rgb_gray(fresnel_dielectric(g.cosine, lobe->eta))
                                                       : coated_conductor(lobe, g.cosine, through_o, through_i);
    *out = (bsdf_value_t){rgb_scale(rgb_mul(lobe->color, fresnel), g.f), g.pdf, g.pdf_reverse};
}

/* ---- sample ---- */

static bool glossy_sample(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double rest, const double u[2],
                          vec3_t *wi)
{
    const vec3_t m = ggx_sample(lobe->alpha_u, lobe->alpha_v, wo, u[0], u[1]);
    const double c = smaller(vec3_dot(wo, m), 1);
    if (!(c > 0))
        return false;
    if (lobe->kind == BSDF_DIELECTRIC) {
        double g;
        if (rest >= fresnel_dielectric_g(c, eta, &g)) {
            /* wi = ((c - g) m - wo) / eta, c - g = -(eta^2 - 1) / (c + g) */
            const double along = -(eta - 1) * (eta + 1) / (c + g);
            *wi = vec3_scale(vec3_sub(vec3_scale(m, along), wo), 1 / eta);
            return wi->z < 0;
        }
    }
    *wi = vec3_sub(vec3_scale(m, 2 * c), wo);
    return wi->z > 0;
}

bool bsdf_lobe_sample(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double rest, const double u[2], vec3_t *wi)
{
    switch (lobe->kind) {
    case BSDF_DIFFUSE:
    case BSDF_COATED_BASE:
        *wi = warp_cosine(u[0], u[1]);
        return wi->z > 0;
    case BSDF_DIFFUSE_TRANSMIT:
        *wi = warp_cosine(u[0], u[1]);
        wi->z = -wi->z;
        return wi->z < 0;
    default:
        return glossy_sample(lobe, eta, wo, rest, u, wi);
    }
}

/* ---- inverse ---- */

/* Strictly below `end`: the place of `t` in [begin, end). */
static double within(double begin, double end, double t)
{
    const double x = begin + t * (end - begin);
    return x < end ? x : fmax(nextafter(end, begin), begin);
}

static void glossy_invert(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, double free_number,
                          double *rest, double u[2])
{
    vec3_t m;
    double c;
    if (wi.z < 0) {
        refraction_t r;
        refraction_of(eta, wo, wi, &r); /* a density exists: so does the facet */
        m = r.m;
        c = r.om;
    } else {
        m = vec3_unit(vec3_add(wo, wi));
        c = smaller(vec3_dot(wo, m), 1);
    }
    ggx_invert(lobe->alpha_u, lobe->alpha_v, wo, m, &u[0], &u[1]);
    *rest = free_number;
    if (lobe->kind == BSDF_DIELECTRIC) {
        const double f = fresnel_dielectric(c, eta);
        *rest = wi.z < 0 ? within(f, 1, free_number) : within(0, f, free_number);
    }
}

void bsdf_lobe_invert(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, double free_number, double *rest,
                      double u[2])
{
    switch (lobe->kind) {
    case BSDF_DIFFUSE:
    case BSDF_COATED_BASE:
    case BSDF_DIFFUSE_TRANSMIT:
        warp_cosine_invert(vec3(wi.x, wi.y, fabs(wi.z)), &u[0], &u[1]);
        *rest = free_number;
        return;
    default:
        glossy_invert(lobe, eta, wo, wi, free_number, rest, u);
    }
}

/* ---- specular ---- */

/* Thin dielectric: R' = R + T^2 R / (1 - R^2) = 2 R / (1 + R), all interreflections between its two faces. */
double bsdf_lobe_reflects(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double *g)
{
    *g = 0;
    switch (lobe->kind) {
    case BSDF_PASS:
        return 0;
    case BSDF_MIRROR_DIELECTRIC:
        return fresnel_dielectric_g(wo.z, eta, g);
    case BSDF_MIRROR_THIN: {
        const double r = fresnel_dielectric_g(wo.z, lobe->eta, g);
        return 2 * r / (1 + r);
    }
    default:
        return 1;
    }
}

/* 1 - bsdf_lobe_reflects without cancellation; of a thin dielectric (1 - R) / (1 + R) = T / (2 - T). */
static double lobe_transmits(const bsdf_lobe_t *lobe, double eta, double c, double reflects, double g)
{
    switch (lobe->kind) {
    case BSDF_MIRROR_DIELECTRIC:
        return fresnel_dielectric_t(c, eta, g);
    case BSDF_MIRROR_THIN: {
        const double t = fresnel_dielectric_t(c, lobe->eta, g);
        return t / (2 - t);
    }
    default:
        return 1 - reflects;
    }
}

/* What a mirror that takes every walk returns of it. */
static rgb_t mirror_coefficient(const bsdf_lobe_t *lobe, double c)
{
    switch (lobe->kind) {
    case BSDF_MIRROR_CONDUCTOR:
        return rgb_mul(lobe->color, fresnel_conductor(c, lobe->eta3, lobe->k3));
    case BSDF_MIRROR_COAT:
        return rgb_scale(lobe->color, fresnel_dielectric(c, lobe->eta));
    case BSDF_MIRROR_COATED_CONDUCTOR:
        return rgb_mul(lobe->color,
                       bsdf_coated_mirror(fresnel_dielectric(c, lobe->eta), bsdf_coated_fresnel(lobe, c)));
    default:
        return lobe->color;
    }
}

void bsdf_lobe_specular(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double reflects, double g, bool transmitted,
                        bsdf_mode_t mode, bsdf_specular_t *out)
{
    out->transmitted = transmitted;
    out->eta = 1;
    if (!transmitted) {
        out->wi = vec3(-wo.x, -wo.y, wo.z);
        out->probability = reflects;
        /* of a lobe that also transmits, the coefficient holds the event's share of light */
        out->coefficient = rgb_scale(mirror_coefficient(lobe, wo.z), reflects);
        return;
    }
    out->probability = lobe_transmits(lobe, eta, wo.z, reflects, g);
    out->coefficient = rgb_scale(lobe->color, out->probability);
    out->wi = vec3_neg(wo);
    if (lobe->kind != BSDF_MIRROR_DIELECTRIC || !(out->probability > 0))
        return;
    const double inverse = 1 / eta;
    out->wi = vec3(-wo.x * inverse, -wo.y * inverse, -g * inverse);
    out->eta = eta;
    if (mode == BSDF_RADIANCE)
        out->coefficient = rgb_scale(out->coefficient, inverse * inverse);
}
