/* warp_turns.h: sine and cosine of an angle in turns, the one function of the maps that is written for doubles bit
 * by bit: builds in another precision put theirs in its place (tests/hard/extended).
 *
 * Pure; any thread.
 */
#ifndef MATH_WARP_TURNS_H
#define MATH_WARP_TURNS_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Sine and cosine of 2 pi u, u in [0,1). The nearest quarter q/4 is subtracted (exactly), the rest r in [-1/8,1/8]
 * goes through polynomials in r^2 that interpolate sin(2 pi r)/r and cos(2 pi r) at Chebyshev nodes (approximation
 * error 1.3e-17 and 1.9e-17 relative); 2 pi is carried in two doubles. Error below 1.1 ulp (measured: 1.04);
 * quarters are exact. No branch, no call. */
static inline void warp_sincos_turns(double u, double *s, double *c)
{
    const int64_t quarter = (int64_t)(4.0 * u + 0.5);
    const double r = u - 0.25 * (double)quarter;
    const double z = r * r;
    double ps = 0x1.e4a9d9166f052p+1, pc = -0x1.b2f3eb054afcdp+0;
    ps = fma(z, ps, -0x1.e3027dea82bd7p+3);
    pc = fma(z, pc, 0x1.f9ce245cada0bp+2);
    ps = fma(z, ps, 0x1.50783208843ebp+5);
    pc = fma(z, pc, -0x1.a6d1eef479be1p+4);
    ps = fma(z, ps, -0x1.32d2cce500387p+6);
    pc = fma(z, pc, 0x1.e1f5068688d5bp+5);
    ps = fma(z, ps, 0x1.466bc6775a476p+6);
    pc = fma(z, pc, -0x1.55d3c7e3cb241p+6);
    ps = fma(z, ps, -0x1.4abbce625be52p+5);
    pc = fma(z, pc, 0x1.03c1f081b5ac0p+6);
    pc = fma(z, pc, -0x1.3bd3cc9be45dep+4);
    /* 2 pi = 0x1.921fb54442d18p+2 + 0x1.1a62633145c07p-52 */
    const double sine = fma(r, 0x1.921fb54442d18p+2, r * fma(z, ps, 0x1.1a62633145c07p-52));
    const double cosine = fma(z, pc, 1.0);
    /* odd quarters swap the two; the signs follow the quarter */
    uint64_t sb, cb;
    memcpy(&sb, &sine, sizeof sb);
    memcpy(&cb, &cosine, sizeof cb);
    const uint64_t q = (uint64_t)quarter;
    const uint64_t swap = (sb ^ cb) & (0 - (q & 1));
    sb ^= swap ^ ((q & 2) << 62);
    cb ^= swap ^ (((q + 1) & 2) << 62);
    memcpy(s, &sb, sizeof sb);
    memcpy(c, &cb, sizeof cb);
}

#endif
