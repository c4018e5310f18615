#include "client/lab/charted_reference.h"

#include <math.h>

#include "client/lab/stream.h"

/* Gauss and Legendre's nodes and weights on [-1,1], the positive half (Abramowitz and Stegun, table 25.4). */
enum { NODES8 = 4, NODES4 = 2 };
static const double node8[NODES8] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                     0.9602898564975363};
static const double weight8[NODES8] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                       0.1012285362903763};
static const double node4[NODES4] = {0.3399810435848563, 0.8611363115940526};
static const double weight4[NODES4] = {0.6521451548625461, 0.3478548451374538};

/* Integrals over a light as seen from a point: of f*, and of f* times its place along y. */
typedef struct moments {
    double one, across;
} moments_t;

typedef struct interval {
    double lo, hi; /* empty unless lo < hi */
} interval_t;

static interval_t clip(interval_t a, interval_t b)
{
    return (interval_t){math_max(a.lo, b.lo), math_min(a.hi, b.hi)};
}

/* ---- light 1: radiance(y) x / (2 pi) (1/s - 1/(1+s)) along y, s = x^2 + (y - y0)^2 ---- */

static void add_light1_at(moments_t *m, double x, double y0, double q, double weight)
{
    const double y = y0 + x * sinh(q), s = x * x + (y - y0) * (y - y0);
    const double f = charted_radiance(0, y) * 0.5 * MATH_INV_PI * x / (s * (1 + s)) * x * cosh(q) * weight;
    m->one += f;
    m->across += f * y;
}

static void add_light1(moments_t *m, double x, double y0, interval_t y)
{
    if (!(y.lo < y.hi))
        return;
    const double from = asinh((y.lo - y0) / x), to = asinh((y.hi - y0) / x);
    const int panels = 1 + (int)(to - from);
    const double half = 0.5 * (to - from) / panels;
    for (int p = 0; p < panels; p++) {
        const double middle = from + (2 * p + 1) * half;
        for (int k = 0; k < NODES8; k++) {
            add_light1_at(m, x, y0, middle - half * node8[k], half * weight8[k]);
            add_light1_at(m, x, y0, middle + half * node8[k], half * weight8[k]);
        }
    }
}

/* What the strip covers of the plane at `distance` from (x, y0), itself at `strip` in the same direction. */
static interval_t shadow(double y0, double strip, double distance)
{
    if (!(strip > 0))
        return (interval_t){INFINITY, INFINITY};
    return (interval_t){y0 + (CHARTED_STRIP_Y0 - y0) * distance / strip,
                        y0 + (CHARTED_STRIP_Y1 - y0) * distance / strip};
}

static moments_t light1(double x, double y0)
{
    const interval_t whole = {0, 1}, dark = shadow(y0, x - CHARTED_STRIP_X, x);
    moments_t m = {0, 0};
    add_light1(&m, x, y0, clip(whole, (interval_t){-INFINITY, dark.lo}));
    add_light1(&m, x, y0, clip(whole, (interval_t){dark.hi, INFINITY}));
    return m;
}

/* ---- light 2: over the part of the hole through which the light is seen ---- */

static double hole_column(double run, double y0, double y, double top)
{
    const double s = run * run + (y - y0) * (y - y0);
    return 0.5 * run * (1 / (s + CHARTED_HOLE_Z0 * CHARTED_HOLE_Z0) - 1 / (s + top * top));
}

static double hole_part(double run, double y0, interval_t y, double top)
{
    if (!(y.lo < y.hi))
        return 0;
    const double half = 0.5 * (y.hi - y.lo), middle = y.lo + half;
    double sum = 0;
    for (int k = 0; k < NODES8; k++)
        sum += half * weight8[k] *
               (hole_column(run, y0, middle - half * node8[k], top) +
                hole_column(run, y0, middle + half * node8[k], top));
    return charted_radiance(1, 0) * MATH_INV_PI * sum;
}

static double light2(double x, double y0)
{
    const double run = CHARTED_SCREEN_X - x, scale = run / (CHARTED_LIGHT2_X - x); /* light to screen */
    const double top = math_min(CHARTED_HOLE_Z1, scale);
    if (!(top > CHARTED_HOLE_Z0))
        return 0;
    const interval_t seen =
        clip((interval_t){CHARTED_HOLE_Y0, CHARTED_HOLE_Y1}, (interval_t){y0 - y0 * scale, y0 + (1 - y0) * scale});
    const interval_t dark = shadow(y0, CHARTED_STRIP_X - x, run);
    return hole_part(run, y0, clip(seen, (interval_t){-INFINITY, dark.lo}), top) +
           hole_part(run, y0, clip(seen, (interval_t){dark.hi, INFINITY}), top);
}

/* ---- the picture ---- */

rgb_t charted_ground(double x, double y, double *target)
{
    const moments_t first = light1(x, y);
    const double second = light2(x, y);
    if (target)
        *target = first.one + second;
    /* colour (1, y, 1-y): linear in y, so the moments tell it */
    const rgb_t colour = rgb(first.one, first.across, first.one - first.across);
    return rgb_mad(colour, second, charted_colour(1, 0));
}

/* Place and weight of point i of four on [0,1]. */
static double gauss4(int i, double *weight)
{
    const int k = i < NODES4 ? NODES4 - 1 - i : i - NODES4;
    *weight = 0.5 * weight4[k];
    return 0.5 + (i < NODES4 ? -0.5 : 0.5) * node4[k];
}

static rgb_t pixel_mean(int column, int row, double *target)
{
    rgb_t sum = rgb_gray(0);
    for (int j = 0; j < 2 * NODES4; j++)
        for (int i = 0; i < 2 * NODES4; i++) {
            double wx, wy, here;
            const double x = (column + gauss4(i, &wx)) / CHARTED_SIDE, y = (row + gauss4(j, &wy)) / CHARTED_SIDE;
            sum = rgb_mad(sum, wx * wy, charted_ground(x, y, &here));
            *target += wx * wy * here;
        }
    return sum;
}

double charted_reference(charted_picture_t *picture)
{
    double target = 0;
    for (int row = 0; row < CHARTED_SIDE; row++)
        for (int column = 0; column < CHARTED_SIDE; column++) {
            const rgb_t mean = pixel_mean(column, row, &target);
            double *pixel = picture->rgb[row * CHARTED_SIDE + column];
            pixel[0] = mean.r;
            pixel[1] = mean.g;
            pixel[2] = mean.b;
        }
    return target / CHARTED_PIXELS;
}

double charted_error(const charted_picture_t *a, const charted_picture_t *b)
{
    double sum = 0;
    for (int p = 0; p < CHARTED_PIXELS; p++)
        for (int c = 0; c < 3; c++) {
            const double off = a->rgb[p][c] - b->rgb[p][c];
            sum += off * off;
        }
    return sqrt(sum / (3 * CHARTED_PIXELS));
}

/* ---- constants ---- */

/* The mean of C = f* / (p_1 + p_2) over one shifted sequence. */
static double shifted_mean(int chart, uint64_t points, stream_t *stream)
{
    const double root = 1.1673039782614187; /* g^5 = g + 1 */
    double u[CHARTED_NUMBERS], step[CHARTED_NUMBERS], power = 1, sum = 0;
    for (int d = 0; d < CHARTED_NUMBERS; d++) {
        power /= root;
        step[d] = power;
        u[d] = stream_uniform(stream);
    }
    for (uint64_t i = 0; i < points; i++) {
        const charted_path_t path = charted_sample(chart, u);
        if (path.target > 0)
            sum += path.target / (path.density[0] + path.density[1]);
        for (int d = 0; d < CHARTED_NUMBERS; d++) {
            u[d] += step[d];
            u[d] -= u[d] >= 1;
        }
    }
    return sum / (double)points;
}

double charted_share(int chart, uint64_t points, uint64_t seed, double *error)
{
    double sum = 0, squares = 0, means[CHARTED_SHIFTS];
    for (int s = 0; s < CHARTED_SHIFTS; s++) {
        stream_t stream = stream_of(seed, (uint64_t)(chart * CHARTED_SHIFTS + s));
        means[s] = shifted_mean(chart, points, &stream);
        sum += means[s] / CHARTED_SHIFTS;
    }
    for (int s = 0; s < CHARTED_SHIFTS; s++)
        squares += (means[s] - sum) * (means[s] - sum);
    *error = sqrt(squares / (CHARTED_SHIFTS - 1) / CHARTED_SHIFTS);
    return sum;
}

charted_constants_t charted_constants(double b, uint64_t points, uint64_t seed)
{
    double e0, e1;
    const double first = charted_share(CHARTED_LIGHT, points, seed, &e0);
    const double second = charted_share(CHARTED_DIRECTION, points, seed, &e1);
    const double v0 = e0 * e0, v1 = e1 * e1;
    const double combined = (first * v1 + (b - second) * v0) / (v0 + v1);
    return (charted_constants_t){b, {combined, b - combined}, sqrt(v0 * v1 / (v0 + v1))};
}
