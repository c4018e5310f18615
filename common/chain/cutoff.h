/* cutoff.h: independent samples that go to long paths only now and then.
 *
 * A bidirectional sample of lengths up to K traces two walks of K segments and joins them in some K^2 / 2 ways,
 * most of them for the light of long paths, of which there is little. Here each sample is made up to a length L of
 * its own, drawn with P(L >= k) = rate_k, and counts a path of length k as 1 / rate_k: unbiased for any rates in
 * (0, 1] that do not rise with k and are fixed beforehand. (Truncating a path by a law that does not look at it is
 * as old as Russian roulette, Arvo and Kirk 1990; here the law is of lengths, the same for all samples, and drawn
 * in a stratified way, which a roulette on throughputs cannot be.) How the plan chooses: stats/rates.h.
 *
 * The numbers of a sample's walks are the same whatever L is. The number that L is drawn with is one of the
 * sample's point (net.h): any few of them in a row are spread evenly over the law. */
#ifndef CHAIN_CUTOFF_H
#define CHAIN_CUTOFF_H

#include <stdint.h>

/* The largest length whose rate is above u. rates[k - 1] of length k = 1 .. count; rates[0] is 1. */
static inline uint32_t cutoff_length(const double *rates, uint32_t count, double u)
{
    uint32_t length = 1;
    while (length < count && u < rates[length])
        length++;
    return length;
}

#endif
