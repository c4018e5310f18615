/* bsdf_coat.h: a dielectric coat over a base, in closed form: what the coat reflects, and what reaches the base.
 *
 * E(w): directional albedo of the coat's own reflection lobe; T(w) = 1 - E(w) enters the base. The exact Fresnel
 * reflectance for a smooth coat; for a rough one a table over the cosine, made by quadrature. A diffuse base of
 * reflectance rho is then f = T(wi) T(wo) rho / (pi eta^2 (1 - rho Fi)),   1 - Fi = Tbar / eta^2,   Tbar = 2
 * int_0^1 T(mu) mu dmu (Saunderson 1942 for the internal reflections; the product of transmittances over their
 * mean: Kelemen and Szirmay-Kalos 2001, eq. 6). It is reciprocal; its albedo is T(wo) rho (1 - Fi) / (1 - rho Fi),
 * which is T(wo) at rho = 1: with the coat's own E(wo) exactly 1. For a smooth coat it is the exact solution
 * (docs/materials.md).
 */
#ifndef SCENE_BSDF_COAT_H
#define SCENE_BSDF_COAT_H

#include <stdint.h>

#include "base/fault.h"
#include "math/vec.h"
#include "scene/fresnel.h"

typedef enum bsdf_coat_kind {
    BSDF_COAT_SMOOTH = 0,
    BSDF_COAT_ROUGH,       /* one row */
    BSDF_COAT_ANISOTROPIC, /* rows over |cos| of the azimuth from the rougher axis, 0 to 1 */
    BSDF_COAT_TEXTURED     /* rows over sqrt(alpha), from 0 (smooth) to 1; isotropic */
} bsdf_coat_kind_t;

enum {
    BSDF_COAT_INTERVALS = 128,                  /* of a row, over sqrt(mu) */
    BSDF_COAT_STRIDE = BSDF_COAT_INTERVALS + 3, /* nodes and one ghost at each end */
    BSDF_COAT_ANISOTROPIC_ROWS = 17,
    BSDF_COAT_TEXTURED_ROWS = 33
};

typedef struct bsdf_coat {
    uint32_t kind; /* bsdf_coat_kind_t */
    uint32_t rows;
    double eta, alpha_u, alpha_v;
    double transmittance;      /* Tbar, for all kinds but textured */
    double *albedo;            /* rows x BSDF_COAT_STRIDE: E at the nodes; null for smooth coats */
    double *row_transmittance; /* Tbar of each row; null for smooth coats */
} bsdf_coat_t;

/* The number of rows that a coat of this kind takes: what its memory and its making cost. */
uint32_t bsdf_coat_rows(uint32_t kind);

/* Makes the coat's tables. alpha_u, alpha_v are not looked at for smooth and textured coats. */
fault_code_t bsdf_coat_init(bsdf_coat_t *coat, uint32_t kind, double eta, double alpha_u, double alpha_v,
                            fault_t *fault);
void bsdf_coat_clear(bsdf_coat_t *coat);

/* The row position of an alpha, for textured coats; 0 for others and for smooth places. */
double bsdf_coat_row(const bsdf_coat_t *coat, double alpha_u, double alpha_v);

/* E by table, for rough coats. */
double bsdf_coat_table_albedo(const bsdf_coat_t *coat, vec3_t w, double row);

/* E(w); w.z in (0,1]. *through is T(w) = 1 - E(w): for a smooth coat computed as such, as little of it is left in E
 * at grazing. A table is within 5e-4 of the lobe's albedo; those that are linear between rows within 1e-3
 * (anisotropic, 4 to 1) and 4e-3 (textured) (tests/scene/test_bsdf_coat.c). */
static inline double bsdf_coat_albedo(const bsdf_coat_t *coat, vec3_t w, double row, double *through)
{
    double albedo;
    if (coat->kind == BSDF_COAT_SMOOTH) {
        double g;
        albedo = fresnel_dielectric_g(w.z, coat->eta, &g);
        *through = fresnel_dielectric_t(w.z, coat->eta, g);
    } else {
        albedo = bsdf_coat_table_albedo(coat, w, row);
        *through = 1 - albedo;
    }
    return albedo;
}

/* Fi = 1 - Tbar / eta^2: the interface's mean reflectance from inside. */
double bsdf_coat_inner(const bsdf_coat_t *coat, double row);

/* E by quadrature of the lobe itself: what the table holds. `quality` multiplies the number of nodes each way; 1 is
 * what tables are made with. */
double bsdf_coat_quadrature(double eta, double alpha_u, double alpha_v, vec3_t w, int quality);

#endif
