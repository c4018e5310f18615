#include "scene/bsdf_coat.h"

#include <stdbool.h>
#include <stdlib.h>

#include "math/warp.h"
#include "scene/ggx.h"
#include "scene/quadrature.h"

enum { NODES_AZIMUTH = 48, NODES_CAP = 72, MAX_NODES = 256, AZIMUTHS = 64, NODES_ROW = 4 };
/* The first node of a row stands for mu = 0, where no visible normal exists. */
#define FIRST_MU 1e-7

typedef struct rule {
    int azimuths, caps;
    double x[MAX_NODES], w[MAX_NODES]; /* Gauss and Legendre in sqrt(u2), in which the cap is smooth */
} rule_t;

static void rule_init(rule_t *rule, int quality)
{
    rule->azimuths = NODES_AZIMUTH * quality;
    rule->caps = NODES_CAP * quality < MAX_NODES ? NODES_CAP * quality : MAX_NODES;
    quadrature_gauss(rule->caps, rule->x, rule->w);
}

/* E(w) = int F(w.m) G2/G1 du1 du2 over the visible normals of w; the midpoint rule in u1, where the integrand is
 * periodic; half of it where the normals of w are symmetric. */
static double lobe_albedo(const rule_t *rule, double eta, double au, double av, vec3_t w)
{
    double sum = 0;
    const int azimuths = w.y == 0 ? rule->azimuths / 2 : rule->azimuths;
    for (int j = 0; j < rule->caps; j++) {
        const double u2 = rule->x[j] * rule->x[j];
        double ring = 0;
        for (int i = 0; i < azimuths; i++) {
            const vec3_t m = ggx_sample(au, av, w, (i + 0.5) / rule->azimuths, u2);
            const double c = vec3_dot(w, m);
            const vec3_t wi = vec3_sub(vec3_scale(m, 2 * c), w);
            if (wi.z > 0 && c > 0)
                ring += fresnel_dielectric(c < 1 ? c : 1, eta) * ggx_g2(au, av, w, wi);
        }
        sum += 2 * rule->x[j] * rule->w[j] * ring;
    }
    return sum / (azimuths * ggx_g1(au, av, w));
}

double bsdf_coat_quadrature(double eta, double alpha_u, double alpha_v, vec3_t w, int quality)
{
    rule_t rule;
    rule_init(&rule, quality);
    return lobe_albedo(&rule, eta, alpha_u, alpha_v, w);
}

uint32_t bsdf_coat_rows(uint32_t kind)
{
    return kind == BSDF_COAT_SMOOTH        ? 0
           : kind == BSDF_COAT_ROUGH       ? 1
           : kind == BSDF_COAT_ANISOTROPIC ? BSDF_COAT_ANISOTROPIC_ROWS
                                           : BSDF_COAT_TEXTURED_ROWS;
}

/* Cubic through four neighbours (Catmull and Rom 1974). p[1] at t = 0, p[2] at t = 1. */
static inline double cubic(const double *p, double t)
{
    const double a = 0.5 * (p[3] - p[0]) + 1.5 * (p[1] - p[2]);
    const double b = p[0] - 2.5 * p[1] + 2 * p[2] - 0.5 * p[3];
    const double c = 0.5 * (p[2] - p[0]);
    return ((a * t + b) * t + c) * t + p[1];
}

/* node[0] and node[STRIDE - 1] are ghosts: the parabola through the three nodes next to them. */
static void row_extend(double *node)
{
    double *end = node + BSDF_COAT_STRIDE - 1;
    node[0] = 3 * (node[1] - node[2]) + node[3];
    end[0] = 3 * (end[-1] - end[-2]) + end[-3];
}

/* 2 int (1 - E) mu dmu of the interpolant itself: with mu = s^2 it is 4 int (1 - E) s^3 ds, of degree 6 on each
 * interval, which four nodes of Gauss integrate exactly. */
static double row_transmittance(const double *node)
{
    double x[NODES_ROW], w[NODES_ROW], sum = 0;
    quadrature_gauss(NODES_ROW, x, w);
    for (int i = 0; i < BSDF_COAT_INTERVALS; i++) {
        for (int k = 0; k < NODES_ROW; k++) {
            const double s = (i + x[k]) / BSDF_COAT_INTERVALS;
            sum += w[k] * 4 * s * s * s * (1 - cubic(node + i, x[k]));
        }
    }
    return sum / BSDF_COAT_INTERVALS;
}

/* A row at azimuth (cos, sin); alpha 0: smooth. */
static double row_fill(double *node, const rule_t *rule, double eta, double au, double av, double cosine,
                       double sine)
{
    for (int i = 0; i <= BSDF_COAT_INTERVALS; i++) {
        const double s = (double)i / BSDF_COAT_INTERVALS;
        const double mu = fmax(s * s, FIRST_MU);
        const double r = sqrt((1 - mu) * (1 + mu));
        node[1 + i] =
            au > 0 ? lobe_albedo(rule, eta, au, av, vec3(r * cosine, r * sine, mu)) : fresnel_dielectric(mu, eta);
    }
    row_extend(node);
    return row_transmittance(node);
}

static void rows_fill(bsdf_coat_t *coat, const rule_t *rule)
{
    for (uint32_t row = 0; row < coat->rows; row++) {
        const double at = coat->rows > 1 ? row / (coat->rows - 1.0) : 1;
        double *node = coat->albedo + (size_t)row * BSDF_COAT_STRIDE;
        const bool textured = coat->kind == BSDF_COAT_TEXTURED;
        const double au = textured ? at * at : coat->alpha_u, av = textured ? at * at : coat->alpha_v;
        const double along = textured ? 1 : at, across = sqrt((1 - along) * (1 + along));
        const bool u_rougher = au >= av;
        coat->row_transmittance[row] =
            row_fill(node, rule, coat->eta, au, av, u_rougher ? along : across, u_rougher ? across : along);
    }
}

/* The mean over the azimuth of what is linear in the cosine between rows. */
static double mean_transmittance(const bsdf_coat_t *coat)
{
    double sum = 0;
    for (int i = 0; i < AZIMUTHS; i++) {
        const double x = cos(0.5 * MATH_PI * (i + 0.5) / AZIMUTHS) * (coat->rows - 1);
        const uint32_t row = coat->rows < 2 ? 0 : (uint32_t)fmin(x, coat->rows - 2);
        const double next = coat->rows < 2 ? coat->row_transmittance[0] : coat->row_transmittance[row + 1];
        sum += coat->row_transmittance[row] + (x - row) * (next - coat->row_transmittance[row]);
    }
    return sum / AZIMUTHS;
}

fault_code_t bsdf_coat_init(bsdf_coat_t *coat, uint32_t kind, double eta, double alpha_u, double alpha_v,
                            fault_t *fault)
{
    *coat = (bsdf_coat_t){
        .kind = kind, .rows = bsdf_coat_rows(kind), .eta = eta, .alpha_u = alpha_u, .alpha_v = alpha_v};
    if (kind == BSDF_COAT_SMOOTH) {
        coat->transmittance = 1 - fresnel_diffuse(eta);
        return FAULT_NONE;
    }
    coat->albedo = calloc((size_t)coat->rows * BSDF_COAT_STRIDE, sizeof *coat->albedo);
    coat->row_transmittance = calloc(coat->rows, sizeof *coat->row_transmittance);
    if (!coat->albedo || !coat->row_transmittance) {
        bsdf_coat_clear(coat);
        return fault_set(fault, FAULT_MEMORY, "no memory for a coat's table of %u rows", bsdf_coat_rows(kind));
    }
    rule_t rule;
    rule_init(&rule, 1);
    rows_fill(coat, &rule);
    coat->transmittance = mean_transmittance(coat);
    return FAULT_NONE;
}

void bsdf_coat_clear(bsdf_coat_t *coat)
{
    free(coat->albedo);
    free(coat->row_transmittance);
    *coat = (bsdf_coat_t){0};
}

double bsdf_coat_row(const bsdf_coat_t *coat, double alpha_u, double alpha_v)
{
    if (coat->kind != BSDF_COAT_TEXTURED)
        return 0;
    const double alpha = sqrt(alpha_u * alpha_v);
    return fmin(sqrt(alpha), 1) * (coat->rows - 1);
}

double bsdf_coat_table_albedo(const bsdf_coat_t *coat, vec3_t w, double row)
{
    const double x = sqrt(w.z) * BSDF_COAT_INTERVALS;
    const int i = x < BSDF_COAT_INTERVALS - 1 ? (int)x : BSDF_COAT_INTERVALS - 1;
    const double t = x - i;
    const double *node = coat->albedo + i;
    double e;
    if (coat->rows == 1) {
        e = cubic(node, t);
    } else {
        if (coat->kind == BSDF_COAT_ANISOTROPIC) {
            const double r2 = w.x * w.x + w.y * w.y;
            const double along = coat->alpha_u >= coat->alpha_v ? w.x : w.y;
            row = r2 > 0 ? fabs(along) / sqrt(r2) * (coat->rows - 1) : 0;
        }
        const uint32_t below = row < coat->rows - 2 ? (uint32_t)row : coat->rows - 2;
        node += (size_t)below * BSDF_COAT_STRIDE;
        const double e0 = cubic(node, t), e1 = cubic(node + BSDF_COAT_STRIDE, t);
        e = e0 + (row - below) * (e1 - e0);
    }
    return e < 1 ? (e > 0 ? e : 0) : 1;
}

double bsdf_coat_inner(const bsdf_coat_t *coat, double row)
{
    double transmittance = coat->transmittance;
    if (coat->kind == BSDF_COAT_TEXTURED) {
        const uint32_t below = row < coat->rows - 2 ? (uint32_t)row : coat->rows - 2;
        const double *t = coat->row_transmittance + below;
        transmittance = t[0] + (row - below) * (t[1] - t[0]);
    }
    return 1 - transmittance / (coat->eta * coat->eta);
}
