#include "client/import/spectra.h"

#include <stdint.h>
#include <string.h>

/* ---- colour matching ---- */

typedef struct xyz {
    double x, y, z;
} xyz_t;

/* A Gaussian with different widths on its two sides. */
static double lobe(double wavelength, double height, double centre, double left, double right)
{
    const double t = (wavelength - centre) / (wavelength < centre ? left : right);
    return height * exp(-0.5 * t * t);
}

/* Wyman, Sloan and Shirley 2013, section 2.2 (CIE 1931, 2 degrees). */
static xyz_t matching(double w)
{
    return (xyz_t){lobe(w, 1.056, 599.8, 37.9, 31.0) + lobe(w, 0.362, 442.0, 16.0, 26.7) +
                       lobe(w, -0.065, 501.1, 20.4, 26.2),
                   lobe(w, 0.821, 568.8, 46.9, 40.5) + lobe(w, 0.286, 530.9, 16.3, 31.1),
                   lobe(w, 1.217, 437.0, 11.8, 36.0) + lobe(w, 0.681, 459.0, 26.0, 13.8)};
}

/* IEC 61966-2-1: XYZ to linear RGB, Rec. 709 primaries, white D65. */
static rgb_t to_rgb(xyz_t c)
{
    return rgb(3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z,
               -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
               0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z);
}

/* Planck: spectral radiance, up to a constant; wavelength in nm. c2 = hc/k = 1.438777e7 nm K. */
static double planck(double wavelength, double kelvin)
{
    const double x = wavelength / 560.0;
    return 1 / (x * x * x * x * x * expm1(1.438777e7 / (wavelength * kelvin)));
}

enum { FIRST_NM = 380, LAST_NM = 730, STEP_NM = 1 };

static rgb_t clamp_low(rgb_t c)
{
    return rgb(fmax(c.r, 0), fmax(c.g, 0), fmax(c.b, 0));
}

/* Colours outside the gamut lose their negative channels before the scaling: the luminance is 1 in the end. */
static rgb_t light_color(rgb_t c)
{
    const rgb_t positive = clamp_low(c);
    const double luminance = rgb_luminance(positive);
    return luminance > 0 && isfinite(luminance) ? rgb_scale(positive, 1 / luminance) : rgb(0, 0, 0);
}

typedef double value_fn(const void *data, double wavelength);

static rgb_t color_of_light(value_fn *value, const void *data)
{
    rgb_t sum = {0, 0, 0};
    for (int nm = FIRST_NM; nm <= LAST_NM; nm += STEP_NM)
        sum = rgb_mad(sum, value(data, nm), to_rgb(matching(nm)));
    return light_color(sum);
}

/* Averages under a white: a black body of 6504 K stands in for D65; the division makes white exactly 1. */
static rgb_t average(value_fn *value, const void *data)
{
    rgb_t sum = {0, 0, 0}, weight = {0, 0, 0};
    for (int nm = FIRST_NM; nm <= LAST_NM; nm += STEP_NM) {
        const rgb_t m = rgb_scale(to_rgb(matching(nm)), planck(nm, 6504));
        weight = rgb_add(weight, m);
        sum = rgb_mad(sum, value(data, nm), m);
    }
    return clamp_low(rgb(sum.r / weight.r, sum.g / weight.g, sum.b / weight.b));
}

static rgb_t convert(value_fn *value, const void *data, spectra_use_t use)
{
    if (use == SPECTRA_LIGHT)
        return color_of_light(value, data);
    const rgb_t c = average(value, data);
    return use == SPECTRA_REFLECTANCE ? rgb(fmin(c.r, 1), fmin(c.g, 1), fmin(c.b, 1)) : c;
}

/* ---- black bodies ---- */

typedef struct blackbody {
    double kelvin, scale;
} blackbody_t;

static double blackbody_value(const void *data, double wavelength)
{
    const blackbody_t *b = data;
    return b->scale * planck(wavelength, b->kelvin);
}

rgb_t spectra_blackbody(double kelvin, spectra_use_t use)
{
    /* The maximum is at Wien's displacement, 2.8977721e6 nm K / T. Relative to the largest visible value first, so
     * that a cold body does not underflow. */
    blackbody_t body = {kelvin, 1};
    const double peak = 2.8977721e6 / kelvin;
    if (use == SPECTRA_LIGHT)
        body.scale = 1 / planck(fmin(fmax(peak, FIRST_NM), LAST_NM), kelvin);
    else
        body.scale = 1 / planck(peak, kelvin);
    if (!isfinite(body.scale))
        return rgb(0, 0, 0);
    return convert(blackbody_value, &body, use);
}

/* ---- tables ---- */

typedef struct pairs {
    const double *values;
    size_t count;
} pairs_t;

double spectra_pairs_at(const double *pairs, size_t count, double wavelength)
{
    if (wavelength <= pairs[0])
        return pairs[1];
    if (wavelength >= pairs[2 * count - 2])
        return pairs[2 * count - 1];
    size_t low = 0, high = count - 1; /* pairs[low] <= wavelength < pairs[high] */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (pairs[2 * middle] <= wavelength)
            low = middle;
        else
            high = middle;
    }
    const double t = (wavelength - pairs[2 * low]) / (pairs[2 * high] - pairs[2 * low]);
    return pairs[2 * low + 1] * (1 - t) + pairs[2 * high + 1] * t;
}

bool spectra_pairs_valid(const double *pairs, size_t count)
{
    for (size_t i = 0; i + 1 < count; i++)
        if (!(pairs[2 * i] < pairs[2 * i + 2]))
            return false;
    return count > 0;
}

static double pairs_value(const void *data, double wavelength)
{
    const pairs_t *p = data;
    return spectra_pairs_at(p->values, p->count, wavelength);
}

rgb_t spectra_of_pairs(const double *pairs, size_t count, spectra_use_t use)
{
    const pairs_t p = {pairs, count};
    return convert(pairs_value, &p, use);
}

/* ---- names ---- */

typedef struct metal {
    const char *name;
    rgb_t eta, k;
} metal_t;

/* Complex indices of refraction, red, green, blue.
 * Ag: tables of Lynch and Hunter (in Palik: Handbook of optical constants of solids, 1985) at 630, 532 and 465 nm.
 * Al, Au, Cu: the projections of measured spectra to linear RGB that Bitterli's published scenes (Rendering
 * resources, 2016) use for these metals: broad bands, which suits the coloured metals better than three wavelengths
 * do. CuZn (brass): Querry (Optical constants of minerals and other materials, 1985) at 650, 550 and 450 nm. MgO:
 * dispersion formula of Stephens and Malitson (J. Res. NBS 49, 1952); TiO2 (rutile, ordinary ray): DeVore (J. Opt.
 * Soc. Am. 41, 1951); both at 630, 532 and 465 nm. */
static const metal_t metals[] = {
    {"Ag", {0.134, 0.129, 0.140}, {3.97, 3.21, 2.61}},
    {"Al", {1.65746, 0.880369, 0.521229}, {9.223869, 6.269523, 4.837001}},
    {"Au", {0.1431189557, 0.3749570432, 1.4424785571}, {3.9831604247, 2.3857207478, 1.6032152899}},
    {"Cu", {0.200438, 0.924033, 1.102212}, {3.912949, 2.452848, 2.142188}},
    {"CuZn", {0.444, 0.527, 1.094}, {3.695, 2.765, 1.829}},
    {"MgO", {1.7348, 1.7421, 1.7501}, {0, 0, 0}},
    {"TiO2", {2.5853, 2.6678, 2.7765}, {0, 0, 0}},
};

/* Index at the helium d line, 587.6 nm, from the makers' data sheets (Schott); diamond: Peter, 1923. */
static const struct {
    const char *name;
    double eta;
} glasses[] = {{"glass-BK7", 1.5168},   {"glass-BAF10", 1.6700}, {"glass-FK51A", 1.4866},
               {"glass-LASF9", 1.8503}, {"glass-F5", 1.6034},    {"glass-SF5", 1.6727},
               {"glass-SF10", 1.7283},  {"glass-SF11", 1.7847},  {"glass-diamond", 2.4175}};

/* Chromaticities (x, y) of standard illuminants: CIE 15:2004, tables T.3 and T.8; ACES D60: SMPTE ST 2065-1. */
static const struct {
    const char *name;
    double x, y;
} illuminants[] = {
    {"stdillum-A", 0.44758, 0.40745},    {"stdillum-D50", 0.34567, 0.35851}, {"stdillum-D65", 0.31272, 0.32903},
    {"illum-acesD60", 0.32168, 0.33767}, {"stdillum-F1", 0.3131, 0.3371},    {"stdillum-F2", 0.3721, 0.3751},
    {"stdillum-F3", 0.4091, 0.3941},     {"stdillum-F4", 0.4402, 0.4031},    {"stdillum-F5", 0.3138, 0.3452},
    {"stdillum-F6", 0.3779, 0.3882},     {"stdillum-F7", 0.3129, 0.3292},    {"stdillum-F8", 0.3458, 0.3586},
    {"stdillum-F9", 0.3741, 0.3727},     {"stdillum-F10", 0.3458, 0.3588},   {"stdillum-F11", 0.3805, 0.3769},
    {"stdillum-F12", 0.4370, 0.4042},
};

static bool named_metal(const char *name, rgb_t *out)
{
    for (size_t i = 0; i < sizeof metals / sizeof *metals; i++) {
        const size_t length = strlen(metals[i].name);
        if (strncmp(name, "metal-", 6) != 0 || strncmp(name + 6, metals[i].name, length) != 0)
            continue;
        const char *part = name + 6 + length;
        const bool eta = strcmp(part, "-eta") == 0;
        if (eta || strcmp(part, "-k") == 0) {
            *out = eta ? metals[i].eta : metals[i].k;
            return true;
        }
    }
    return false;
}

static bool named_illuminant(const char *name, spectra_use_t use, rgb_t *out)
{
    for (size_t i = 0; i < sizeof illuminants / sizeof *illuminants; i++)
        if (strcmp(name, illuminants[i].name) == 0) {
            const double x = illuminants[i].x, y = illuminants[i].y;
            *out = light_color(to_rgb((xyz_t){x / y, 1, (1 - x - y) / y}));
            if (use == SPECTRA_REFLECTANCE)
                *out = rgb_scale(*out, 1 / rgb_max(*out));
            return true;
        }
    return false;
}

bool spectra_named(const char *name, spectra_use_t use, rgb_t *out)
{
    bool found = named_metal(name, out);
    for (size_t i = 0; !found && i < sizeof glasses / sizeof *glasses; i++)
        if (strcmp(name, glasses[i].name) == 0) {
            *out = rgb_gray(glasses[i].eta);
            found = true;
        }
    if (!found)
        return named_illuminant(name, use, out);
    if (use == SPECTRA_REFLECTANCE)
        *out = rgb(fmin(out->r, 1), fmin(out->g, 1), fmin(out->b, 1));
    if (use == SPECTRA_LIGHT)
        *out = light_color(*out);
    return true;
}
