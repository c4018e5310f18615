/* bsdf_lobes.h: single lobes, for bsdf.c alone: value and densities, sample, inverse.
 *
 * Everything here is in the flipped frame: wo.z > 0, and wi.z tells reflection (> 0) from transmission (< 0). `eta`
 * is the index on the far side over that on wo's side. Densities leave out the probability of choosing the lobe,
 * but contain that of choosing reflection or refraction inside it.
 */
#ifndef SCENE_BSDF_LOBES_H
#define SCENE_BSDF_LOBES_H

#include "scene/bsdf.h"

/* What a lobe needs to know of a direction w: how it is chosen, and what its coat does. */
typedef struct bsdf_share {
    double probability; /* alpha_l(w) */
    double coat;        /* E(w) of its coat, 0 without one */
    double through;     /* T(w) = 1 - E(w) */
} bsdf_share_t;

/* Value and densities of a smooth lobe for a pair; `through_o`, `through_i` are T(wo), T(wi). Zero where
 * nothing scatters. */
void bsdf_lobe_eval(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, double through_o, double through_i,
                    bsdf_mode_t mode, bsdf_value_t *out);

/* A direction of a smooth lobe; rest in [0,1) chooses between reflection and refraction. False if there is none. */
bool bsdf_lobe_sample(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double rest, const double u[2], vec3_t *wi);

/* The numbers that make bsdf_lobe_sample return wi, where bsdf_lobe_eval has a density; `free_number` places *rest
 * within its interval. */
void bsdf_lobe_invert(const bsdf_lobe_t *lobe, double eta, vec3_t wo, vec3_t wi, double free_number, double *rest,
                      double u[2]);

/* A specular event. */
typedef struct bsdf_specular {
    vec3_t wi;
    rgb_t coefficient;  /* f cos / p in the discrete measure */
    double probability; /* of this event within the lobe, the same both ways */
    double eta;         /* of the index, where refracted; else 1 */
    bool transmitted;
} bsdf_specular_t;

/* Probability that a specular lobe reflects. *g: index times the refracted cosine, of a dielectric lobe. */
double bsdf_lobe_reflects(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double *g);

/* The specular event that `transmitted` names; probability 0 if there is none. `reflects` and g are
 * bsdf_lobe_reflects's. */
void bsdf_lobe_specular(const bsdf_lobe_t *lobe, double eta, vec3_t wo, double reflects, double g, bool transmitted,
                        bsdf_mode_t mode, bsdf_specular_t *out);

/* F + T^2 C / (1 - F C) per channel: a smooth coat of reflectance F over a mirror of reflectance C. */
rgb_t bsdf_coated_mirror(double coat, rgb_t conductor);

/* Conductor reflectance under a coat of index eta, for the cosine c outside. */
rgb_t bsdf_coated_fresnel(const bsdf_lobe_t *lobe, double c);

#endif
