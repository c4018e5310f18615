/* bsdf.h: scattering at a point: a mixture of lobes, with sample, value, density and inverse side by side.
 *
 * bsdf_at resolves a material at a hit (textures looked up, mixtures flattened) into a bsdf_t of at most
 * BSDF_MAX_LOBES lobes. Directions are local: z along the shading normal, both pointing away from the surface.
 * `wo` is where the walk came from, `wi` where it goes to.
 *
 * Values are f (1/sr); densities are per solid angle of wi. A walk's direction matters in two places, both given by
 * bsdf_mode_t: refraction scales radiance by 1/eta^2 but not importance (Veach 1997, section 5.2), and shading normals make f
 * asymmetric (ibid., 5.3: that factor is the path's, as it needs the geometric normal).
 *
 * Specular (delta) lobes: their "value" is the coefficient f cos / p in the discrete measure and their density is the
 * discrete probability of the lobe; they exist for bsdf_sample only. bsdf_eval sees the others.
 *
 * Dimensions: u[0] chooses the lobe (and reflection or refraction inside it), u[1], u[2] the direction.
 * Hot calls: no allocation, no checks; wo.z != 0 is the caller's to see to. All functions are pure.
 */
#ifndef SCENE_BSDF_H
#define SCENE_BSDF_H

#include <stdbool.h>

#include "math/vec.h"
#include "scene/scene.h"

enum { BSDF_MAX_LOBES = 6, BSDF_DIMENSIONS = 3 };

typedef enum bsdf_mode {
    BSDF_RADIANCE = 0,  /* the walk started at the camera: wi points towards the light */
    BSDF_IMPORTANCE = 1 /* the walk started at a light: wi points towards the camera */
} bsdf_mode_t;

/* Kinds of lobe: the unit of sampling. */
typedef enum bsdf_lobe_kind {
    BSDF_DIFFUSE = 0,         /* Lambert, the side of wo */
    BSDF_DIFFUSE_TRANSMIT,    /* Lambert, the other side */
    BSDF_COATED_BASE,         /* diffuse under a dielectric coat: closed form, see bsdf_coat.h */
    BSDF_CONDUCTOR,           /* GGX reflection with conductor Fresnel */
    BSDF_COAT,                /* GGX reflection with dielectric Fresnel, no transmission (a coat's surface) */
    BSDF_DIELECTRIC,          /* GGX reflection and refraction */
    BSDF_MIRROR_CONDUCTOR,    /* specular ones from here on */
    BSDF_MIRROR_COAT,
    BSDF_MIRROR_DIELECTRIC,   /* specular reflection and refraction */
    BSDF_MIRROR_THIN,         /* thin dielectric: reflection or straight on */
    BSDF_PASS,                /* index-matched: straight on */
    BSDF_LOBE_KINDS
} bsdf_lobe_kind_t;

#define BSDF_KIND_IS_SPECULAR(kind) ((kind) >= BSDF_MIRROR_CONDUCTOR)

typedef struct bsdf_lobe {
    uint32_t kind;         /* bsdf_lobe_kind_t */
    uint32_t coat;         /* index of the coat's table, for BSDF_COATED_BASE and lobes under a coat */
    double weight;         /* share of the mixture (material mixes): multiplies value, not density */
    rgb_t color;           /* reflectance, transmittance */
    double alpha_u, alpha_v;
    double eta;            /* dielectric: interior over exterior */
    rgb_t eta3, k3;        /* conductor */
} bsdf_lobe_t;

typedef struct bsdf {
    uint32_t count;        /* of lobes; 0: absorbs everything */
    uint32_t flags;        /* BSDF_HAS_... */
    bsdf_lobe_t lobes[BSDF_MAX_LOBES];
} bsdf_t;

enum {
    BSDF_HAS_SMOOTH = 1,   /* some lobe is not specular: the vertex can be connected */
    BSDF_HAS_SPECULAR = 2,
    BSDF_HAS_TRANSMISSION = 4,
    BSDF_ONLY_DIFFUSE = 8  /* exactly one lobe, BSDF_DIFFUSE: the fast path */
};

/* What one sampling decision gave. */
typedef struct bsdf_sample {
    vec3_t wi;
    rgb_t weight;      /* f |cos wi| / pdf (smooth: of the whole smooth mixture), or the specular coefficient / probability */
    double pdf;        /* of wi given wo: solid angle (all smooth lobes), or discrete (specular) */
    double pdf_reverse; /* of wo given wi, the other mode: same measure */
    double eta;        /* interior over exterior seen from wo when refracted, else 1 */
    uint32_t lobe;
    bool specular;
    bool transmitted;
} bsdf_sample_t;

typedef struct bsdf_value {
    rgb_t f;            /* without the cosine */
    double pdf;         /* of wi given wo */
    double pdf_reverse; /* of wo given wi */
} bsdf_value_t;

/* Tables that materials need (coats' directional albedos, ...), made once per scene. */
typedef struct bsdf_tables bsdf_tables_t;
fault_code_t bsdf_tables_new(bsdf_tables_t **out, const scene_t *scene, fault_t *fault);
void bsdf_tables_destroy(bsdf_tables_t **tables);

/* Resolves material at texture coordinates (u,v) into *out. `material` is not an interface (BSDF_PASS is made for
 * one inside a mix). */
void bsdf_at(const scene_t *scene, const bsdf_tables_t *tables, uint32_t material, double u, double v, bsdf_t *out);

/* Samples wi; false if nothing is scattered (absorbed, below the horizon, numerically void). u in [0,1)^3. */
bool bsdf_sample(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, const double u[3], bsdf_mode_t mode,
                 bsdf_sample_t *out);

/* Value and both densities of the smooth lobes for a pair of directions. All zero where nothing scatters. */
void bsdf_eval(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, bsdf_mode_t mode,
               bsdf_value_t *out);

/* The inverse: numbers u with bsdf_sample(u) = wi, ambiguity resolved by the three uniform numbers `free`. `specular`
 * and `lobe` say what the path recorded (a specular lobe keeps its identity; a smooth one is drawn with probability
 * alpha_l p_l / sum). False if wi cannot be made. (docs/transport.md, inverse samplers.) */
bool bsdf_invert(const bsdf_t *bsdf, const bsdf_tables_t *tables, vec3_t wo, vec3_t wi, bool specular, uint32_t lobe,
                 bsdf_mode_t mode, const double free_numbers[3], double u[3]);

/* True if the material exists for light: not an interface. */
static inline bool bsdf_material_visible(const scene_t *scene, int32_t material)
{
    return scene->materials[material].kind != SCENE_MATERIAL_INTERFACE;
}

#endif
