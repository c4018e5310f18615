/* extended.h: makes of any source of common/math and common/scene the same code in extended precision.
 *
 * The compiler includes it before the first line of each source of the extended build (-include). After it the word
 * `double` means long double (on x86 a mantissa of 64 bits: 2048 times the precision), and the mathematical
 * functions are those of long double. System headers are included before, as they mean what they say.
 *
 * What stays in double precision: literals without a suffix that no double holds exactly. Of these only pi matters
 * to what is compared; the constants are given again below. math/warp_turns.h, which is written for the bits of a
 * double, has a counterpart in the folder `instead`, which stands
 * before common among the include paths.
 *
 * All arithmetic that differs is then rounding: the extended build is a double build whose errors are 2048 times
 * smaller, and so the reference for the other's (probe.h).
 */
#ifndef EXTENDED_H
#define EXTENDED_H

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "probe.h"

#define EXTENDED_PI 3.14159265358979323846264338327950288L

typedef long double extended_t;
#define double extended_t
#define long /* in `long double`; elsewhere it only stands in what faults print */
#define acos acosl
#define asinh asinhl
#define atan atanl
#define atan2 atan2l
#define ceil ceill
#define copysign copysignl
#define cos cosl
#define cosh coshl
#define erf erfl
#define exp expl
#define fabs fabsl
#define floor floorl
#define fma fmal
#define fmax fmaxl
#define fmin fminl
#define log logl
#define nextafter nextafterl
#define pow powl
#define rint rintl
#define sin sinl
#define sinh sinhl
#define sqrt sqrtl
#define tan tanl

#include "math/vec.h"
#undef MATH_PI
#undef MATH_INV_PI
#undef MATH_ONE_MINUS
#define MATH_PI EXTENDED_PI
#define MATH_INV_PI 0.318309886183790671537767526745028724L
#define MATH_ONE_MINUS 0x1.fffffffffffffffep-1L /* the largest below 1 */

#endif
