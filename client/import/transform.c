#include "client/import/transform.h"

transform_t transform_identity(void)
{
    return transform_scale(1, 1, 1);
}

transform_t transform_mul(const transform_t *a, const transform_t *b)
{
    transform_t out;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            out.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] +
                          a->m[i][3] * b->m[3][j];
    return out;
}

transform_t transform_translate(double x, double y, double z)
{
    return (transform_t){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}}};
}

transform_t transform_scale(double x, double y, double z)
{
    return (transform_t){{{x, 0, 0, 0}, {0, y, 0, 0}, {0, 0, z, 0}, {0, 0, 0, 1}}};
}

transform_t transform_rotate(double degrees, vec3_t axis)
{
    const vec3_t a = vec3_unit(axis);
    const double angle = degrees * (MATH_PI / 180.0), s = sin(angle), c = cos(angle), d = 1 - c;
    return (transform_t){{{a.x * a.x * d + c, a.x * a.y * d - a.z * s, a.x * a.z * d + a.y * s, 0},
                          {a.y * a.x * d + a.z * s, a.y * a.y * d + c, a.y * a.z * d - a.x * s, 0},
                          {a.z * a.x * d - a.y * s, a.z * a.y * d + a.x * s, a.z * a.z * d + c, 0},
                          {0, 0, 0, 1}}};
}

bool transform_look_at(vec3_t eye, vec3_t target, vec3_t up, transform_t *out)
{
    const vec3_t ahead = vec3_sub(target, eye);
    if (!(vec3_length(ahead) > 0) || !(vec3_length(up) > 0))
        return false;
    const vec3_t forward = vec3_unit(ahead), side = vec3_cross(vec3_unit(up), forward);
    if (!(vec3_length(side) > 0))
        return false;
    const vec3_t right = vec3_unit(side), top = vec3_cross(forward, right);
    const transform_t to_world = {{{right.x, top.x, forward.x, eye.x},
                                   {right.y, top.y, forward.y, eye.y},
                                   {right.z, top.z, forward.z, eye.z},
                                   {0, 0, 0, 1}}};
    return transform_invert(&to_world, out);
}

bool transform_finite(const transform_t *a)
{
    double sum = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            sum += a->m[i][j] * 0.0; /* NaN for infinities too */
    return sum == 0;
}

bool transform_affine(const transform_t *a)
{
    return a->m[3][0] == 0 && a->m[3][1] == 0 && a->m[3][2] == 0 && a->m[3][3] == 1;
}

/* Gauss-Jordan elimination with partial pivoting of the rows. */
bool transform_invert(const transform_t *a, transform_t *out)
{
    transform_t work = *a, inverse = transform_identity();
    for (int column = 0; column < 4; column++) {
        int pivot = column;
        for (int row = column + 1; row < 4; row++)
            if (fabs(work.m[row][column]) > fabs(work.m[pivot][column]))
                pivot = row;
        const double value = work.m[pivot][column];
        if (!(fabs(value) > 0))
            return false;
        for (int j = 0; j < 4; j++) {
            const double w = work.m[pivot][j], v = inverse.m[pivot][j];
            work.m[pivot][j] = work.m[column][j];
            inverse.m[pivot][j] = inverse.m[column][j];
            work.m[column][j] = w / value;
            inverse.m[column][j] = v / value;
        }
        for (int row = 0; row < 4; row++) {
            const double factor = work.m[row][column];
            if (row == column || factor == 0)
                continue;
            for (int j = 0; j < 4; j++) {
                work.m[row][j] -= factor * work.m[column][j];
                inverse.m[row][j] -= factor * inverse.m[column][j];
            }
        }
    }
    *out = inverse;
    return transform_finite(out);
}

vec3_t transform_point(const transform_t *a, vec3_t p)
{
    return vec3(a->m[0][0] * p.x + a->m[0][1] * p.y + a->m[0][2] * p.z + a->m[0][3],
                a->m[1][0] * p.x + a->m[1][1] * p.y + a->m[1][2] * p.z + a->m[1][3],
                a->m[2][0] * p.x + a->m[2][1] * p.y + a->m[2][2] * p.z + a->m[2][3]);
}

vec3_t transform_vector(const transform_t *a, vec3_t v)
{
    return vec3(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}

vec3_t transform_transposed(const transform_t *a, vec3_t v)
{
    return vec3(a->m[0][0] * v.x + a->m[1][0] * v.y + a->m[2][0] * v.z,
                a->m[0][1] * v.x + a->m[1][1] * v.y + a->m[2][1] * v.z,
                a->m[0][2] * v.x + a->m[1][2] * v.y + a->m[2][2] * v.z);
}

static vec3_t column(const transform_t *a, int j)
{
    return vec3(a->m[0][j], a->m[1][j], a->m[2][j]);
}

double transform_determinant(const transform_t *a)
{
    return vec3_dot(vec3_cross(column(a, 0), column(a, 1)), column(a, 2));
}

bool transform_similarity(const transform_t *a, double *scale)
{
    /* Matrices are written with about six digits: columns of equal length and at right angles to 2e-5. */
    const double tolerance = 2e-5;
    const vec3_t x = column(a, 0), y = column(a, 1), z = column(a, 2);
    const double s = cbrt(fabs(transform_determinant(a))), s2 = s * s;
    *scale = s;
    if (!(s > 0) || !isfinite(s))
        return false;
    const double worst =
        fmax(fmax(fabs(vec3_length(x) / s - 1), fabs(vec3_length(y) / s - 1)),
             fmax(fabs(vec3_length(z) / s - 1),
                  fmax(fabs(vec3_dot(x, y)), fmax(fabs(vec3_dot(y, z)), fabs(vec3_dot(z, x)))) / s2));
    return worst <= tolerance;
}
