#include "chain/kernel.h"

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "math/warp.h"

kernel_t kernel_of(const settings_t *settings)
{
    return (kernel_t){settings->kernel, settings->step_max, log2(settings->step_max / settings->step_min)};
}

/* 2^x for x in [-1000, 0]; the polynomial is the minimax one of degree 4 for 2^f on [0,1). */
static inline double kernel_exp2(double x)
{
    const int64_t whole = (int64_t)x - 1; /* below x: x is not positive */
    const double f = x - (double)whole;
    const double p = 1.0000026 + f * (0.69300383 + f * (0.24144275 + f * (0.052011464 + f * 0.013534167)));
    const uint64_t bits = (uint64_t)(1023 + whole) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

static inline double kernel_wrap(double u)
{
    u += u < 0 ? 1.0 : 0.0;
    u -= u >= 1 ? 1.0 : 0.0;
    return u < MATH_ONE_MINUS ? u : MATH_ONE_MINUS; /* -1e-20 + 1 rounds to 1 */
}

static void kernel_kelemen(const kernel_t *kernel, uint64_t key, uint64_t first, const double *from, double *to,
                           uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t bits = random_u64(key, first + i);
        const double step = kernel->size * kernel_exp2(-kernel->log_ratio * random_double_of(bits));
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

void kernel_draw(uint64_t key, uint64_t first, double *to, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        to[i] = random_double(key, first + i);
}
