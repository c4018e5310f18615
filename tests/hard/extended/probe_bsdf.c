/* probe_bsdf.c: Fresnel, GGX, lobes and their mixtures. Compiled with either build. */
#include "probe_list.h"
#include "scene/bsdf.h"
#include "scene/bsdf_coat.h"
#include "scene/ggx.h"

/* ---- Fresnel ---- */

static bool run_dielectric(const double *in, double *out)
{
    out[0] = fresnel_dielectric_g(in[1], in[0], &out[2]);
    out[1] = fresnel_dielectric_t(in[1], in[0], out[2]);
    return true;
}

static bool run_conductor(const double *in, double *out)
{
    out[0] = fresnel_conductor1(in[2], in[0], in[1]);
    return true;
}

static bool run_diffuse_mean(const double *in, double *out)
{
    out[0] = fresnel_diffuse(in[0]);
    return true;
}

/* ---- GGX ---- */

static bool run_ggx_sample(const double *in, double *out)
{
    const vec3_t wo = probe_vec(in + 2), m = ggx_sample(in[0], in[1], wo, in[5], in[6]);
    probe_put(out, m);
    out[3] = m.z;
    return true;
}

static bool run_ggx_visible(const double *in, double *out)
{
    out[0] = ggx_visible_pdf(in[0], in[1], probe_vec(in + 2), probe_vec(in + 5));
    return out[0] > 0;
}

static bool run_ggx_reflect(const double *in, double *out)
{
    const ggx_reflection_t g = ggx_reflect(in[0], in[1], probe_vec(in + 2), probe_vec(in + 5));
    out[0] = g.f;
    out[1] = g.pdf;
    out[2] = g.pdf_reverse;
    out[3] = g.cosine;
    return in[7] > 0;
}

static bool run_ggx_shadowing(const double *in, double *out)
{
    const vec3_t wo = probe_vec(in + 2), wi = probe_vec(in + 5);
    out[0] = ggx_lambda(in[0], in[1], wo);
    out[1] = ggx_g1(in[0], in[1], wo);
    out[2] = ggx_g2(in[0], in[1], wo, wi);
    return true;
}

/* The facet is drawn here, by numbers rounded to what either build holds exactly. */
static bool run_ggx_invert(const double *in, double *out)
{
    const vec3_t wo = probe_vec(in + 2), m = vec3_unit(vec3_add(wo, probe_vec(in + 5)));
    if (!(in[7] > 0 && vec3_dot(m, wo) > 0))
        return false;
    ggx_invert(in[0], in[1], wo, m, &out[0], &out[1]);
    return true;
}

/* ---- lobes ---- */

static void make_lobe(bsdf_t *bsdf, uint32_t kind, double au, double av, double eta, double n, double k)
{
    *bsdf = (bsdf_t){.count = 1, .flags = BSDF_KIND_IS_SPECULAR(kind) ? BSDF_HAS_SPECULAR : BSDF_HAS_SMOOTH};
    bsdf->lobes[0] = (bsdf_lobe_t){.kind = kind,
                                   .select = 1,
                                   .color = rgb(1, 1, 1),
                                   .alpha_u = au,
                                   .alpha_v = av,
                                   .eta = eta,
                                   .eta3 = rgb_gray(n),
                                   .k3 = rgb_gray(k)};
}

/* A rough coat over a diffuse base; how lobes are shared out by a smooth coat's reflectance. */
static bsdf_tables_t make_coated(bsdf_t *bsdf, bsdf_coat_t *coat, double au, double av, double eta)
{
    make_lobe(bsdf, BSDF_COAT, au, av, eta, 0, 0);
    *coat = (bsdf_coat_t){.kind = BSDF_COAT_SMOOTH, .eta = eta};
    coat->transmittance = 1 - fresnel_diffuse(eta);
    bsdf->count = 2;
    bsdf->lobes[1] = (bsdf_lobe_t){.kind = BSDF_COATED_BASE, .select = 1, .color = rgb_gray(1)};
    return (bsdf_tables_t){.coats = coat, .coat_count = 1};
}

static bool sample(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, const double u[3], double *out)
{
    bsdf_sample_t s;
    if (!bsdf_sample(bsdf, tables, wo, u, BSDF_RADIANCE, &s))
        return false;
    probe_put(out, s.wi);
    out[3] = s.wi.z;
    out[4] = s.specular ? s.weight.r : 0; /* those of smooth lobes are of the rounded direction: eval's */
    out[5] = s.specular ? s.pdf : 0;
    return true;
}

static bool eval(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, double *out)
{
    bsdf_value_t v;
    bsdf_eval(bsdf, tables, wo, wi, BSDF_RADIANCE, &v);
    out[0] = v.f.r;
    out[1] = v.pdf;
    out[2] = v.pdf_reverse;
    return v.pdf > 0;
}

/* The free number that places u0 in its interval is its middle. */
static bool invert(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, double *out)
{
    static const double half[3] = {0.5, 0.5, 0.5};
    return bsdf_invert(bsdf, tables, wo, wi, false, 0, BSDF_RADIANCE, half, out);
}

static bool run_metal_sample(const double *in, double *out)
{
    bsdf_t bsdf;
    make_lobe(&bsdf, BSDF_CONDUCTOR, in[0], in[1], 1, in[8], in[9]);
    return sample(&bsdf, NULL, probe_vec(in + 2), in + 5, out);
}

static bool run_metal_eval(const double *in, double *out)
{
    bsdf_t bsdf;
    make_lobe(&bsdf, BSDF_CONDUCTOR, in[0], in[1], 1, in[8], in[9]);
    return eval(&bsdf, NULL, probe_vec(in + 2), probe_vec(in + 5), out);
}

static bool run_glass_sample(const double *in, double *out)
{
    bsdf_t bsdf;
    make_lobe(&bsdf, BSDF_DIELECTRIC, in[0], in[1], in[2], 0, 0);
    return sample(&bsdf, NULL, probe_vec(in + 3), in + 6, out);
}

static bool run_glass_eval(const double *in, double *out)
{
    bsdf_t bsdf;
    make_lobe(&bsdf, BSDF_DIELECTRIC, in[0], in[1], in[2], 0, 0);
    return eval(&bsdf, NULL, probe_vec(in + 3), probe_vec(in + 6), out);
}

static bool run_glass_invert(const double *in, double *out)
{
    bsdf_t bsdf;
    make_lobe(&bsdf, BSDF_DIELECTRIC, in[0], in[1], in[2], 0, 0);
    return invert(&bsdf, NULL, probe_vec(in + 3), probe_vec(in + 6), out);
}

static bool run_smooth_glass(const double *in, double *out)
{
    bsdf_t bsdf;
    make_lobe(&bsdf, BSDF_MIRROR_DIELECTRIC, 0, 0, in[0], 0, 0);
    return sample(&bsdf, NULL, probe_vec(in + 1), in + 4, out);
}

static bool run_coated_sample(const double *in, double *out)
{
    bsdf_t bsdf;
    bsdf_coat_t coat;
    const bsdf_tables_t tables = make_coated(&bsdf, &coat, in[0], in[1], in[2] > 1 ? in[2] : 1 / in[2]);
    return sample(&bsdf, &tables, probe_vec(in + 3), in + 6, out);
}

static bool run_coated_eval(const double *in, double *out)
{
    bsdf_t bsdf;
    bsdf_coat_t coat;
    const bsdf_tables_t tables = make_coated(&bsdf, &coat, in[0], in[1], in[2] > 1 ? in[2] : 1 / in[2]);
    return eval(&bsdf, &tables, probe_vec(in + 3), probe_vec(in + 6), out);
}

const probe_t probe_scattering[] = {
    {{"Fresnel, dielectric", "ec", {{"F", 1, 0}, {"T", 1, 0}, {"g", 1, 0}}, 0}, run_dielectric},
    {{"Fresnel, conductor", "ikc", {{"F", 1, 0}}, 0}, run_conductor},
    {{"Fresnel, diffuse mean", "e", {{"F", 1, 0}}, 0}, run_diffuse_mean},
    {{"visible normals", "aawuu", {{"m", 3, 0}, {"m.z", 1, 0}}, 0}, run_ggx_sample},
    {{"visible normals, density", "aawg", {{"density", 1, 0}}, 0}, run_ggx_visible},
    {{"visible normals, inverse", "aawm", {{"u1", 1, 0}, {"u2", 1, 0}}, 0}, run_ggx_invert},
    {{"GGX reflection", "aawm", {{"f", 1, 0}, {"density", 1, 0}, {"reverse", 1, 0}, {"cosine", 1, 0}}, 0},
     run_ggx_reflect},
    {{"GGX shadowing", "aaww", {{"Lambda", 1, 0}, {"G1", 1, 0}, {"G2", 1, 0}}, 0}, run_ggx_shadowing},
    {{"rough metal, sample", "aawuuuik", {{"wi", 3, 0}, {"wi.z", 1, 0}}, 0}, run_metal_sample},
    {{"rough metal, value", "aawmik", {{"f", 1, 0}, {"density", 1, 0}, {"reverse", 1, 0}}, 0}, run_metal_eval},
    {{"rough glass, sample", "aaewuuu", {{"wi", 3, 0}, {"wi.z", 1, 0}}, 0}, run_glass_sample},
    {{"rough glass, reflection", "aaewm", {{"f", 1, 0}, {"density", 1, 0}, {"reverse", 1, 0}}, 0}, run_glass_eval},
    {{"rough glass, refraction", "aaewr", {{"f", 1, 0}, {"density", 1, 0}, {"reverse", 1, 0}}, 0}, run_glass_eval},
    {{"rough glass, inverse of reflection", "aaewm", {{"u0", 1, 0}, {"u1", 1, 0}, {"u2", 1, 0}}, 0},
     run_glass_invert},
    {{"rough glass, inverse of refraction", "aaewr", {{"u0", 1, 0}, {"u1", 1, 0}, {"u2", 1, 0}}, 0},
     run_glass_invert},
    {{"smooth glass", "ewuuu", {{"wi", 3, 0}, {"wi.z", 1, 0}, {"weight", 1, 0}, {"density", 1, 0}}, 0},
     run_smooth_glass},
    {{"rough coat, sample", "aaewuuu", {{"wi", 3, 0}, {"wi.z", 1, 0}}, 0}, run_coated_sample},
    {{"rough coat, value", "aaewm", {{"f", 1, 0}, {"density", 1, 0}, {"reverse", 1, 0}}, 0}, run_coated_eval},
    {{NULL, NULL, {{NULL, 0, 0}}, 0}, NULL},
};
