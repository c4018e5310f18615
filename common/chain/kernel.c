#include "chain/kernel.h"

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "math/warp.h"

kernel_t kernel_of(const settings_t *settings)
{
    return (kernel_t){settings->kernel, settings->step_max, log2(settings->step_max / settings->step_min)};
}

/* 2^x for x in [-1000, 0]: the nearest integer by adding and taking off 1.5 2^52, which leaves it in the low bits,
 * and 2^f on [-1/2, 1/2] by its Taylor series to the fifth order (relative error below 3e-6). No conversion between
 * integers and doubles, so that four go at once. */
static inline double kernel_exp2(double x)
{
    const double magic = 0x1.8p52, shifted = x + magic, f = x - (shifted - magic);
    const double p = 1 + f * (0.69314718056 +
                              f * (0.24022650696 + f * (0.05550410866 + f * (0.00961812911 + f * 0.00133335581))));
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

/* The upper 52 bits as a number in [0,1), without a conversion. */
static inline double kernel_unit(uint64_t bits)
{
    const uint64_t word = bits >> 12 | UINT64_C(0x3ff0000000000000);
    double one;
    memcpy(&one, &word, sizeof one);
    return one - 1;
}

static inline double kernel_wrap(double u)
{
    u += u < 0 ? 1.0 : 0.0;
    u -= u >= 1 ? 1.0 : 0.0;
    return u < MATH_ONE_MINUS ? u : MATH_ONE_MINUS; /* -1e-20 + 1 rounds to 1 */
}

static void kernel_kelemen(const kernel_t *kernel, uint64_t key, uint64_t first, const double *restrict from,
                           double *restrict to, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t bits = random_u64(key, first + i);
        const double step = kernel->size * kernel_exp2(-kernel->log_ratio * kernel_unit(bits));
        /* the lowest bit, which the step does not use, is its sign */
        to[i] = kernel_wrap(from[i] + (bits & 1 ? step : -step));
    }
}

static void kernel_gaussian(const kernel_t *kernel, uint64_t key, uint64_t first, const double *from, double *to,
                            uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t bits = random_u64(key, first + i);
        /* both numbers from one word: 32 bits for the angle, 32 for the radius */
        const double radius = sqrt(-2 * log(((double)(bits >> 32) + 0.5) * 0x1p-32));
        double s, c;
        warp_sincos_turns((double)(uint32_t)bits * 0x1p-32, &s, &c);
        const double u = from[i] + kernel->size * radius * c;
        to[i] = kernel_wrap(u - floor(u));
    }
}

void kernel_perturb(const kernel_t *kernel, uint64_t key, uint64_t first, const double *from, double *to,
                    uint32_t count)
{
    (kernel->kind == SETTINGS_KERNEL_KELEMEN ? kernel_kelemen : kernel_gaussian)(kernel, key, first, from, to,
                                                                                 count);
}

kernel_t kernel_scaled(const kernel_t *kernel, double factor)
{
    kernel_t scaled = *kernel;
    scaled.size = math_min(scaled.size * factor, 0.5);
    return scaled;
}

static double kernel_distance(double a, double b)
{
    const double d = fabs(a - b);
    return d < 0.5 ? d : 1 - d;
}

/* log of the density at a distance, up to a constant. Kelemen: 1/d from s1 to s2; the ends are taken a little
 * further than the polynomial's error can carry a step, so that none that was made is thought impossible. */
static double kernel_log_density(const kernel_t *kernel, double distance)
{
    if (kernel->kind == SETTINGS_KERNEL_GAUSSIAN) { /* wrapped round: sigma is at most half a turn */
        double sum = 0;
        for (int turns = -4; turns <= 4; turns++) {
            const double x = (distance + turns) / kernel->size;
            sum += exp(-0.5 * x * x);
        }
        return sum > 0 ? log(sum) : -HUGE_VAL;
    }
    const double slack = 1e-5;
    if (distance > kernel->size * (1 + slack) || distance < kernel->size * exp2(-kernel->log_ratio) * (1 - slack))
        return -HUGE_VAL;
    return -log(distance);
}

double kernel_log_ratio(const kernel_t *kernel, const double *from, const double *via, const double *to,
                        uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double there = kernel_log_density(kernel, kernel_distance(via[i], from[i]));
        const double back = kernel_log_density(kernel, kernel_distance(via[i], to[i]));
        if (!(back > -HUGE_VAL) || !(there > -HUGE_VAL))
            return -HUGE_VAL;
        sum += back - there;
    }
    return sum;
}

void kernel_draw(uint64_t key, uint64_t first, double *to, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        to[i] = random_double(key, first + i);
}
