/* techniques.h: the three sampling techniques of the one-dimensional test and their inverses.
 *
 * After Bitterli, Jakob, Novak, Jarosz: Reversible Jump Metropolis Light Transport using Inverse Mappings (2017),
 * section 7.1: a tent, a step function and a mixture of a sinusoid and a linear function, on [0,1), with a sinusoid
 * as the target. The paper gives shapes, not numbers; the numbers here are
 *
 *     target   f(x) = 1 + 0.8 cos(2 pi x)
 *     tent     p(x) = 4x below 1/2, 4 (1-x) above
 *     step     p(x) = 4 (0.1, 0.4, 0.3, 0.2) on the four quarters
 *     mixture  p(x) = 1/2 (pi/2) sin(pi x) + 1/2 2x
 *
 * A technique maps two numbers to a point: `place` by the inversion method, `choice` to pick a part of a mixture.
 * The step function is sampled as a mixture of its four quarters, so that its choice has intervals of length 0.1 to
 * 0.4; the tent does not use its choice. A technique's inverse draws what is ambiguous (eqs. 21 and 22): the part
 * with probability alpha_t p_t(x) / p(x), the place of `choice` within the part's interval. The Jacobian of the
 * inverse is then p(x), the technique's density, alone (section 6.2): alpha_t p_t of eq. 23 divided by the
 * probability of the part.
 *
 * Pure functions; any thread; arguments in [0,1), unchecked.
 */
#ifndef LAB_TECHNIQUES_H
#define LAB_TECHNIQUES_H

enum { TECHNIQUE_TENT = 0, TECHNIQUE_STEP = 1, TECHNIQUE_MIXTURE = 2, TECHNIQUES = 3 };

extern const char *const techniques_names[TECHNIQUES];

typedef struct technique_numbers {
    double place, choice;
} technique_numbers_t;

double techniques_target(double x);
/* The target's integral from 0 to x; 1 at x = 1. */
double techniques_target_integral(double x);
double techniques_pdf(int technique, double x);
/* The sum of the three densities: the balance heuristic's weight is pdf / sum. */
double techniques_pdf_sum(double x);
double techniques_sample(int technique, technique_numbers_t u);
/* Numbers with techniques_sample(technique, numbers) = x where techniques_pdf(technique, x) > 0. `part` and
 * `within` are uniform: which part of a mixture, and where in the part's interval of `choice`. */
technique_numbers_t techniques_invert(int technique, double x, double part, double within);
/* The integral of w_technique f over [lo, hi], by quadrature (composite midpoint rule, error below 1e-7). Over
 * [0,1] it is the share of a right chain's states that hold the technique. */
double techniques_exact_share(int technique, double lo, double hi);

#endif
