/* bsdf.h: scattering at a point: a mixture of lobes, with sample, value, density and inverse side by side.
 *
 * bsdf_at resolves a material at a hit (textures looked up, mixtures flattened) into a bsdf_t of at most
 * BSDF_MAX_LOBES lobes. Directions are local: z along the shading normal, both pointing away from the surface.
 * `wo` is where the walk came from, `wi` where it goes to.
 *
 * Values are f (1/sr); densities are per solid angle of wi. A walk's direction matters in two places, both given by
 * bsdf_mode_t: refraction scales radiance by 1/eta^2 but not importance (Veach 1997, section 5.2), and shading
 * normals make f asymmetric (ibid., 5.3: that factor is the path's, as it needs the geometric normal).
 *
 * Specular (delta) lobes: their "value" is the coefficient f cos / p in the discrete measure and their density is
 * the discrete probability of the lobe; they exist for bsdf_sample only. bsdf_eval sees the others.
 *
 * Dimensions: u[0] chooses the lobe (and reflection or refraction inside it), u[1], u[2] the direction.
 * Hot calls: no allocation, no checks; wo.z != 0 is the caller's to see to. All functions are pure.
 *
 * A vertex needs a material resolved once. Where no parameter is textured that was done in bsdf_tables_new:
 *
 *     bsdf_t scratch;
 *     const bsdf_t *bsdf = bsdf_resolve(scene, tables, material, u, v, &scratch);
 *     if (bsdf_sample(bsdf, tables, wo, numbers, BSDF_RADIANCE, &sample)) ...
 *
 * Formulas and sources: docs/materials.md.
 */
#ifndef SCENE_BSDF_H
#define SCENE_BSDF_H

#include <stdbool.h>
#include <stddef.h>

#include "math/vec.h"
#include "math/warp.h"
#include "scene/scene.h"

enum { BSDF_MAX_LOBES = 6, BSDF_DIMENSIONS = 3 };

typedef enum bsdf_mode {
    BSDF_RADIANCE = 0,  /* the walk started at the camera: wi points towards the light */
    BSDF_IMPORTANCE = 1 /* the walk started at a light: wi points towards the camera */
} bsdf_mode_t;

/* Kinds of lobe: the unit of sampling. */
typedef enum bsdf_lobe_kind {
    BSDF_DIFFUSE = 0,             /* Lambert, the side of wo */
    BSDF_DIFFUSE_TRANSMIT,        /* Lambert, the other side */
    BSDF_COATED_BASE,             /* diffuse under a dielectric coat: closed form, see bsdf_coat.h */
    BSDF_CONDUCTOR,               /* GGX reflection with conductor Fresnel */
    BSDF_COATED_CONDUCTOR,        /* the same under a coat, attenuated by it on the way in and out */
    BSDF_COAT,                    /* GGX reflection with dielectric Fresnel, no transmission (a coat's surface) */
    BSDF_DIELECTRIC,              /* GGX reflection and refraction */
    BSDF_MIRROR_CONDUCTOR,        /* specular ones from here on */
    BSDF_MIRROR_COATED_CONDUCTOR, /* smooth coat on smooth conductor: one mirror with all interreflections */
    BSDF_MIRROR_COAT,
    BSDF_MIRROR_DIELECTRIC, /* specular reflection and refraction */
    BSDF_MIRROR_THIN,       /* thin dielectric: reflection or straight on */
    BSDF_PASS,              /* index-matched: straight on */
    BSDF_LOBE_KINDS
} bsdf_lobe_kind_t;

#define BSDF_KIND_IS_SPECULAR(kind) ((kind) >= BSDF_MIRROR_CONDUCTOR)

typedef struct bsdf_lobe {
    uint32_t kind; /* bsdf_lobe_kind_t */
    uint32_t coat; /* index into tables->coats, for coats and what lies under them */
    double select; /* estimate of the lobe's albedo without its coat's share: what lobes are chosen by; > 0 */
    rgb_t color;   /* reflectance or transmittance, times the lobe's share of a mixture */
    double alpha_u, alpha_v;
    double eta;      /* dielectric or coat: interior over exterior */
    double coat_row; /* position in the coat's table, for textured coats */
    rgb_t eta3, k3;  /* conductor; relative to the coat's index where there is one */
} bsdf_lobe_t;

typedef struct bsdf {
    uint32_t count; /* of lobes; 0: absorbs everything. Lobes beyond it are not initialised. */
    uint32_t flags; /* BSDF_HAS_... */
    bsdf_lobe_t lobes[BSDF_MAX_LOBES];
} bsdf_t;

enum {
    BSDF_HAS_SMOOTH = 1, /* some lobe is not specular: the vertex can be connected */
    BSDF_HAS_SPECULAR = 2,
    BSDF_HAS_TRANSMISSION = 4,
    BSDF_ONLY_DIFFUSE = 8 /* exactly one lobe, BSDF_DIFFUSE: the fast path */
};

/* What one sampling decision gave. */
typedef struct bsdf_sample {
    vec3_t wi;
    rgb_t weight;       /* f |cos wi| / pdf (smooth: of the whole smooth mixture), or the specular coefficient /
                           probability */
    double pdf;         /* of wi given wo: solid angle (all smooth lobes), or discrete (specular) */
    double pdf_reverse; /* of wo given wi, the other mode: same measure */
    double eta;         /* interior over exterior seen from wo when refracted, else 1 */
    uint32_t lobe;
    bool specular;
    bool transmitted;
} bsdf_sample_t;

typedef struct bsdf_value {
    rgb_t f;            /* without the cosine */
    double pdf;         /* of wi given wo */
    double pdf_reverse; /* of wo given wi */
} bsdf_value_t;

/* What materials need beside the scene, made once per scene: each material whose parameters are all constant,
 * resolved; coats' directional albedos. Immutable after creation; any thread. */
typedef struct bsdf_tables {
    const bsdf_t **ready;    /* per material; null where a parameter is textured */
    const uint32_t *flags;   /* per material: every BSDF_HAS_... that it can show at some place */
    const uint32_t *coat_of; /* per material: its coat, or UINT32_MAX */
    const struct bsdf_coat *coats;
    uint32_t coat_count;
} bsdf_tables_t;

/* Refuses (FAULT_LIMIT, naming the material) mixtures of more than BSDF_MAX_LOBES lobes and scenes with too many
 * different rough coats. The scene has passed scene_check and must outlive the tables. */
fault_code_t bsdf_tables_new(bsdf_tables_t **out, const scene_t *scene, fault_t *fault);
void bsdf_tables_destroy(bsdf_tables_t **tables);

/* Resolves material at texture coordinates (u,v) into *out. A top-level interface resolves to BSDF_PASS as one
 * inside a mix does; walks see to it that they don't come here for it. */
void bsdf_at(const scene_t *scene, const bsdf_tables_t *tables, uint32_t material, double u, double v, bsdf_t *out);

/* The same without a copy: the material resolved beforehand, or *scratch filled. */
static inline const bsdf_t *bsdf_resolve(const scene_t *scene, const bsdf_tables_t *tables, uint32_t material,
                                         double u, double v, bsdf_t *scratch)
{
    const bsdf_t *ready = tables->ready[material];
    if (__builtin_expect(ready != NULL, 1))
        return ready;
    bsdf_at(scene, tables, material, u, v, scratch);
    return scratch;
}

/* Flags that the material can show somewhere (textured roughness may be specular here and smooth there). */
static inline uint32_t bsdf_material_flags(const bsdf_tables_t *tables, uint32_t material)
{
    return tables->flags[material];
}

/* Estimate of the directional albedo seen from wo, at most 1: for feature layers, not for light transport. */
rgb_t bsdf_albedo(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo);

/* The general cases of the three calls below. */
bool bsdf_sample_mixture(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, const double u[3],
                         bsdf_mode_t mode, bsdf_sample_t *out);
void bsdf_eval_mixture(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, bsdf_mode_t mode,
                       bsdf_value_t *out);

/* Samples wi; false if nothing is scattered (absorbed, below the horizon, numerically void): *out is then
 * undefined. u in [0,1)^3. The densities and the value behind the weight are computed from (wo, wi) as bsdf_eval
 * does, not from the microfacet drawn. */
static inline bool bsdf_sample(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, const double u[3],
                               bsdf_mode_t mode, bsdf_sample_t *out)
{
    if (!(bsdf->flags & BSDF_ONLY_DIFFUSE))
        return bsdf_sample_mixture(bsdf, tables, wo, u, mode, out);
    const vec3_t w = warp_cosine(u[1], u[2]);
    out->wi = vec3(w.x, w.y, copysign(w.z, wo.z));
    out->weight = bsdf->lobes[0].color;
    out->pdf = w.z * MATH_INV_PI;
    out->pdf_reverse = fabs(wo.z) * MATH_INV_PI;
    out->eta = 1;
    out->lobe = 0;
    out->specular = false;
    out->transmitted = false;
    return w.z > 0;
}

/* Value and both densities of the smooth lobes for a pair of directions. All zero where nothing scatters. */
static inline void bsdf_eval(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi,
                             bsdf_mode_t mode, bsdf_value_t *out)
{
    if (!(bsdf->flags & BSDF_ONLY_DIFFUSE)) {
        bsdf_eval_mixture(bsdf, tables, wo, wi, mode, out);
        return;
    }
    const double on = wo.z * wi.z > 0 ? MATH_INV_PI : 0;
    out->f = rgb_scale(bsdf->lobes[0].color, on);
    out->pdf = fabs(wi.z) * on;
    out->pdf_reverse = fabs(wo.z) * on;
}

/* The inverse: numbers u with bsdf_sample(u) = wi, ambiguity resolved by the three uniform numbers `free_numbers`.
 * `specular` and `lobe` say what the path recorded (a specular lobe keeps its identity; a smooth one is drawn with
 * probability alpha_l p_l / sum). False if wi cannot be made. For a specular lobe only the side of wi is looked at,
 * which tells reflection from refraction: whether the direction is the specular one is for the caller's round trip
 * to see. (docs/transport.md, inverse samplers.) */
bool bsdf_invert(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, bool specular,
                 uint32_t lobe, bsdf_mode_t mode, const double free_numbers[3], double u[3]);

/* True if the material exists for light: not an interface. */
static inline bool bsdf_material_visible(const scene_t *scene, int32_t material)
{
    return scene->materials[material].kind != SCENE_MATERIAL_INTERFACE;
}

#endif
