/* plan_seeds.c: starts of chains, in proportion to what the pilot's candidates contribute.
 *
 * Systematic resampling puts J chains at equally spaced places of the running sum. How many chains there will be is
 * not known when a rule on time or error ends the job, so chain j takes the place frac(xi + j phi), phi the golden
 * ratio's fraction (Kronecker sequence): any first J of them are spaced almost equally (three-distance theorem),
 * and each alone is uniform as xi is.
 */
#include "plan/plan_seeds.h"

#include "base/random.h"

void plan_prepare_seeds(const plan_t *plan, plan_length_t *length)
{
    double sum = 0;
    for (uint64_t i = 0; i < plan->candidates; i++) {
        sum += length->weights[i];
        length->weights[i] = sum;
    }
}

uint64_t plan_seed(const plan_t *plan, uint32_t k, uint64_t chain)
{
    const plan_length_t *length = &plan->lengths[k];
    const uint64_t key = random_key(plan->settings.seed, RANDOM_PURPOSE_RESAMPLE, k, 0);
    /* frac(xi + j phi) in 64-bit fixed point: wraps exactly */
    const uint64_t place = random_u64(key, 0) + chain * RANDOM_GAMMA; /* 2^64 / golden ratio */
    const double total = length->weights[plan->candidates - 1];
    const double at =
        fmin(random_double_of(place) * total, nextafter(total, 0)); /* below it, even if it is denormal */
    uint64_t low = 0, high = plan->candidates - 1; /* the first candidate whose running sum exceeds `at` */
    while (low < high) {
        const uint64_t middle = (low + high) / 2;
        if (length->weights[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}
