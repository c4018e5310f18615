/* spectra.h: spectra as linear RGB (Rec. 709 primaries): named ones, black bodies and tables of values.
 *
 * Garland renders in RGB; pbrt renders wavelengths. What a spectrum becomes depends on what it is for
 * (spectra_use_t):
 * - a reflectance or an index of refraction: per channel the average of the values, weighted by a D65 white's
 * spectrum and the channel's matching function, such that a constant spectrum keeps its value;
 * - a light's colour: the colour of the spectrum, scaled to the luminance 1, as pbrt-v4 does it for all lights
 * whose colour is not given as rgb. Colour matching: the multi-lobe fit of Wyman, Sloan and Shirley (Simple
 * analytic approximations to the CIE XYZ color matching functions, JCGT 2(2), 2013). Channels below zero (colours
 * outside the gamut) are set to zero.
 *
 * Pure; any thread.
 */
#ifndef IMPORT_SPECTRA_H
#define IMPORT_SPECTRA_H

#include <stdbool.h>
#include <stddef.h>

#include "math/vec.h"

typedef enum spectra_use {
    SPECTRA_REFLECTANCE, /* result in [0,1] */
    SPECTRA_UNBOUNDED,   /* indices of refraction, scale factors: 0 or more */
    SPECTRA_LIGHT        /* luminance 1 */
} spectra_use_t;

/* pbrt-v4's names: "metal-Ag-eta", "glass-BK7", "stdillum-D65", ...; false if there is none. Metals: the table in
 * spectra.c gives the sources. Glasses: the index at 587.6 nm (nd) in all channels. */
bool spectra_named(const char *name, spectra_use_t use, rgb_t *out);

/* Planck's law at temperature T in kelvin (100 to 1e6), for a light or, scaled to the maximum 1, for another use.
 */
rgb_t spectra_blackbody(double kelvin, spectra_use_t use);

/* From `count` pairs (wavelength in nm, value), wavelengths increasing; linear between, constant outside. */
rgb_t spectra_of_pairs(const double *pairs, size_t count, spectra_use_t use);
double spectra_pairs_at(const double *pairs, size_t count, double wavelength);
/* True if the wavelengths increase. */
bool spectra_pairs_valid(const double *pairs, size_t count);

#endif
