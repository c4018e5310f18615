#include "client/lab/techniques.h"

#include <math.h>

#include "math/vec.h"

const char *const techniques_names[TECHNIQUES] = {"tent", "step", "mixture"};

#define TARGET_WAVE 0.8
#define MIXTURE_SINE 0.5 /* the probability of the sinusoid */
enum { QUARTERS = 4 };
static const double quarter_mass[QUARTERS] = {0.1, 0.4, 0.3, 0.2};

double techniques_target(double x)
{
    return 1 + TARGET_WAVE * cos(2 * MATH_PI * x);
}

double techniques_target_integral(double x)
{
    return x + TARGET_WAVE * sin(2 * MATH_PI * x) / (2 * MATH_PI);
}

/* ---- tent: CDF 2 x^2 below 1/2, 1 - 2 (1-x)^2 above ---- */

static double tent_pdf(double x)
{
    return x < 0.5 ? 4 * x : 4 * (1 - x);
}

static double tent_sample(double u)
{
    return u < 0.5 ? sqrt(u / 2) : 1 - sqrt((1 - u) / 2);
}

static double tent_invert(double x)
{
    return x < 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x);
}

/* ---- step: `choice` picks a quarter, `place` is uniform in it ---- */

static int quarter_of(double x)
{
    return (int)(x * QUARTERS);
}

static double step_pdf(double x)
{
    return QUARTERS * quarter_mass[quarter_of(x)];
}

static double step_sample(technique_numbers_t u)
{
    int quarter = 0;
    double end = quarter_mass[0];
    while (quarter < QUARTERS - 1 && u.choice >= end)
        end += quarter_mass[++quarter];
    return (quarter + u.place) / QUARTERS;
}

static technique_numbers_t step_invert(double x, double within)
{
    const int quarter = quarter_of(x);
    double start = 0;
    for (int k = 0; k < quarter; k++)
        start += quarter_mass[k];
    return (technique_numbers_t){x * QUARTERS - quarter, start + within * quarter_mass[quarter]};
}

/* ---- mixture: `choice` below MIXTURE_SINE picks the sinusoid, CDF (1 - cos(pi x)) / 2; else 2x, CDF x^2 ---- */

static double sine_pdf(double x)
{
    return 0.5 * MATH_PI * sin(MATH_PI * x);
}

static double mixture_pdf(double x)
{
    return MIXTURE_SINE * sine_pdf(x) + (1 - MIXTURE_SINE) * 2 * x;
}

static double mixture_sample(technique_numbers_t u)
{
    return u.choice < MIXTURE_SINE ? acos(1 - 2 * u.place) / MATH_PI : sqrt(u.place);
}

static technique_numbers_t mixture_invert(double x, double part, double within)
{
    if (part * mixture_pdf(x) < MIXTURE_SINE * sine_pdf(x))
        return (technique_numbers_t){0.5 * (1 - cos(MATH_PI * x)), MIXTURE_SINE * within};
    return (technique_numbers_t){x * x, MIXTURE_SINE + (1 - MIXTURE_SINE) * within};
}

/* ---- the three ---- */

double techniques_pdf(int technique, double x)
{
    switch (technique) {
    case TECHNIQUE_TENT:
        return tent_pdf(x);
    case TECHNIQUE_STEP:
        return step_pdf(x);
    default:
        return mixture_pdf(x);
    }
}

double techniques_pdf_sum(double x)
{
    return tent_pdf(x) + step_pdf(x) + mixture_pdf(x);
}

double techniques_sample(int technique, technique_numbers_t u)
{
    double x;
    switch (technique) {
    case TECHNIQUE_TENT:
        x = tent_sample(u.place);
        break;
    case TECHNIQUE_STEP:
        x = step_sample(u);
        break;
    default:
        x = mixture_sample(u);
    }
    return math_min(x, MATH_ONE_MINUS); /* rounding */
}

technique_numbers_t techniques_invert(int technique, double x, double part, double within)
{
    technique_numbers_t u;
    switch (technique) {
    case TECHNIQUE_TENT:
        u = (technique_numbers_t){tent_invert(x), within};
        break;
    case TECHNIQUE_STEP:
        u = step_invert(x, within);
        break;
    default:
        u = mixture_invert(x, part, within);
    }
    u.place = math_min(u.place, MATH_ONE_MINUS);
    u.choice = math_min(u.choice, MATH_ONE_MINUS);
    return u;
}

double techniques_exact_share(int technique, double lo, double hi)
{
    enum { PANELS = 4000 }; /* a multiple of four: jumps and kinks of [0,1] fall between panels */
    double sum = 0;
    for (int i = 0; i < PANELS; i++) {
        const double x = lo + (hi - lo) * (i + 0.5) / PANELS;
        sum += techniques_target(x) * techniques_pdf(technique, x) / techniques_pdf_sum(x);
    }
    return sum * (hi - lo) / PANELS;
}
