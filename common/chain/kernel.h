/* kernel.h: symmetric perturbations of numbers on the torus [0,1).
 *
 * Kelemen's kernel (Kelemen et al. 2002, section 4.2): u +- s2 exp(-log(s2/s1) r), r uniform: densities
 * proportional to 1/|du| between s1 and s2. The power of two is a polynomial of relative error below 3e-6: any
 * symmetric kernel serves, so this costs no correctness. Gaussian kernel: standard deviation sigma, by the
 * Box-Muller transform.
 *
 * Number i of the result depends on (key, first + i) and u[i] alone.
 */
#ifndef CHAIN_KERNEL_H
#define CHAIN_KERNEL_H

#include <stdint.h>

#include "chain/settings.h"

typedef struct kernel {
    settings_kernel_t kind;
    double size;      /* s2, or sigma */
    double log_ratio; /* log2(s2 / s1) */
} kernel_t;

kernel_t kernel_of(const settings_t *settings);

/* The same kernel with its steps, all of them, longer by a factor above 0: none is more than half a turn. */
kernel_t kernel_scaled(const kernel_t *kernel, double factor);

/* log of prod_i k(via_i - to_i) / k(via_i - from_i), k the kernel's density on the torus: how much likelier the
 * step from `to` to `via` is than the one from `from` to `via`, which it has made. -infinity where the kernel does
 * not reach. */
double kernel_log_ratio(const kernel_t *kernel, const double *from, const double *via, const double *to,
                        uint32_t count);

/* to[i] = perturbed from[i], i < count. */
void kernel_perturb(const kernel_t *kernel, uint64_t key, uint64_t first, const double *from, double *to,
                    uint32_t count);

/* to[i] = uniform numbers. */
void kernel_draw(uint64_t key, uint64_t first, double *to, uint32_t count);

#endif
