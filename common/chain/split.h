/* split.h: light shared between independent samples and Markov chains.
 *
 * c(x) = C(x) g(x), contribution times importance, is one number for a path, whichever technique made it. With a
 * cap for the path's length
 *
 *     c = min(c, cap) + max(c - cap, 0):
 *
 * samples add f min(1, cap / c): no sample brings more than the cap, so what is easy to sample is left with the
 * noise of well-stratified samples and without fireflies; chains follow max(c - cap, 0) alone, which is the light
 * that is hard to find, and their normalization constant is its integral. The two add up to f for any caps fixed
 * beforehand: unbiased. Caps of 0 are chains that bring all, infinite caps samples that do. How the plan chooses:
 * docs/transport.md, plan/plan_split.c.
 *
 * Splitting the integrand by C is possible as C does not depend on the technique under the balance heuristic
 * (Hachisuka, Kaplanyan, Dachsbacher 2014); the split itself is ours. */
#ifndef CHAIN_SPLIT_H
#define CHAIN_SPLIT_H

/* What chains follow. */
static inline double split_excess(double c, double cap)
{
    return c - cap;
}

/* The part of a contribution that samples bring; c > 0. */
static inline double split_kept(double c, double cap)
{
    return c > cap ? cap / c : 1;
}

#endif
