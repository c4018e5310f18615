/* probe_coat.c: smooth coats over their bases, rough coats' albedos and tables. Compiled with either build. */
#include "probe_list.h"
#include "scene/bsdf.h"
#include "scene/bsdf_coat.h"

/* An index above 1, as coats have. */
static double coat_index(double eta)
{
    return eta > 1 ? eta : 1 / eta;
}

/* ---- smooth coats ---- */

/* A smooth coat over one other lobe: value and densities of the pair, which are the base's, chosen by T. */
static bool base_value(const bsdf_lobe_t *base, double eta, const double *pair, double *out)
{
    bsdf_coat_t coat = {.kind = BSDF_COAT_SMOOTH, .eta = eta};
    bsdf_t bsdf = {.count = 2, .flags = BSDF_HAS_SPECULAR | BSDF_HAS_SMOOTH};
    bsdf.lobes[0] = (bsdf_lobe_t){.kind = BSDF_MIRROR_COAT, .select = 1, .color = rgb_gray(1), .eta = eta};
    bsdf.lobes[1] = *base;
    bsdf.lobes[1].select = 1;
    bsdf.lobes[1].color = rgb_gray(1);
    bsdf_value_t v;
    bsdf_eval(&bsdf, &(bsdf_tables_t){.coats = &coat, .coat_count = 1}, probe_vec(pair), probe_vec(pair + 3),
              BSDF_RADIANCE, &v);
    out[0] = v.f.r;
    out[1] = v.pdf;
    out[2] = v.pdf_reverse;
    return v.pdf > 0;
}

static bool run_coated_diffuse(const double *in, double *out)
{
    const bsdf_lobe_t base = {.kind = BSDF_COATED_BASE};
    return base_value(&base, coat_index(in[0]), in + 1, out);
}

/* alphas 0-1, index 2, wo 3-5, wi 6-8, n 9, k 10 */
static bool run_coated_metal(const double *in, double *out)
{
    const double eta = coat_index(in[2]);
    const bsdf_lobe_t base = {.kind = BSDF_COATED_CONDUCTOR,
                              .alpha_u = in[0],
                              .alpha_v = in[1],
                              .eta = eta,
                              .eta3 = rgb_gray(in[9]),
                              .k3 = rgb_gray(in[10])};
    return base_value(&base, eta, in + 3, out);
}

static bool run_smooth_albedo(const double *in, double *out)
{
    const bsdf_coat_t coat = {.kind = BSDF_COAT_SMOOTH, .eta = coat_index(in[0])};
    out[0] = bsdf_coat_albedo(&coat, probe_vec(in + 1), 0, &out[1]);
    return true;
}

/* ---- rough coats ---- */

static bool run_rough_albedo(const double *in, double *out)
{
    out[0] = bsdf_coat_quadrature(coat_index(in[2]), in[0], in[1], probe_vec(in + 3), 1);
    return true;
}

/* The whole table of an isotropic coat. */
static bool run_rough_table(const double *in, double *out)
{
    bsdf_coat_t coat;
    if (bsdf_coat_init(&coat, BSDF_COAT_ROUGH, coat_index(in[1]), in[0], in[0], NULL))
        return false;
    out[0] = bsdf_coat_albedo(&coat, probe_vec(in + 2), 0, &out[1]);
    out[2] = 1 - bsdf_coat_inner(&coat, 0);
    bsdf_coat_clear(&coat);
    return true;
}

/* Between nodes and rows, whose albedos are here those of smooth coats, less from row to row. */
static bool interpolate(uint32_t kind, const double *in, double row, double *out)
{
    double nodes[BSDF_COAT_TEXTURED_ROWS * BSDF_COAT_STRIDE];
    const double eta = coat_index(in[0]);
    const bsdf_coat_t coat = {.kind = kind,
                              .rows = bsdf_coat_rows(kind),
                              .eta = eta,
                              .alpha_u = in[1],
                              .alpha_v = in[2],
                              .albedo = nodes};
    for (uint32_t i = 0; i < BSDF_COAT_STRIDE; i++) {
        const double s = fmin(fmax((i - 1.0) / BSDF_COAT_INTERVALS, 1e-4), 1);
        nodes[i] = fresnel_dielectric(s * s, eta);
        for (uint32_t r = 1; r < coat.rows; r++)
            nodes[r * BSDF_COAT_STRIDE + i] = nodes[i] * (1 - r / 64.0);
    }
    out[0] = bsdf_coat_albedo(&coat, probe_vec(in + 3), row, &out[1]);
    return true;
}

static bool run_anisotropic(const double *in, double *out)
{
    return interpolate(BSDF_COAT_ANISOTROPIC, in, 0, out);
}

static bool run_textured(const double *in, double *out)
{
    const bsdf_coat_t coat = {.kind = BSDF_COAT_TEXTURED, .rows = BSDF_COAT_TEXTURED_ROWS};
    return interpolate(BSDF_COAT_TEXTURED, in, bsdf_coat_row(&coat, in[1], in[2]), out);
}

#define PAIR                                                                                                       \
    {                                                                                                              \
        {"f", 1, 0}, {"density", 1, 0}, {"reverse", 1, 0},                                                         \
    }

const probe_t probe_coats[] = {
    {{"smooth coat", "ew", {{"E", 1, 0}, {"T", 1, 0}}, 0}, run_smooth_albedo},
    {{"smooth coat over diffuse, value", "eww", PAIR, 0}, run_coated_diffuse},
    {{"smooth coat over rough metal, value", "aaewmik", PAIR, 0}, run_coated_metal},
    {{"rough coat, albedo by quadrature", "aaew", {{"E", 1, 0}}, 50}, run_rough_albedo},
    {{"rough coat, table", "aew", {{"E", 1, 0}, {"T", 1, 1}, {"1 - Fi", 1, 0}}, 500}, run_rough_table},
    {{"rough coat, between nodes and azimuths", "eaaw", {{"E", 1, 0}, {"T", 1, 1}}, 0}, run_anisotropic},
    {{"rough coat, between nodes and alphas", "eaaw", {{"E", 1, 0}, {"T", 1, 1}}, 0}, run_textured},
    {{NULL, NULL, {{NULL, 0, 0}}, 0}, NULL},
};
