/* Vectors of three and 3x3 matrices by value: the little linear algebra that the blocks share. */
#ifndef COMMON_VECTOR_H
#define COMMON_VECTOR_H

#include <math.h>
#include <stdbool.h>

typedef struct {
    double x, y, z;
} Vector;

/* By its rows. */
typedef struct {
    Vector a, b, c;
} Matrix;

static inline Vector vector(const double v[3])
{
    return (Vector){v[0], v[1], v[2]};
}

static inline Matrix matrix(const double m[3][3])
{
    return (Matrix){vector(m[0]), vector(m[1]), vector(m[2])};
}

static inline void store(Vector v, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static inline void store_matrix(Matrix m, double out[3][3])
{
    store(m.a, out[0]);
    store(m.b, out[1]);
    store(m.c, out[2]);
}

static inline Vector add(Vector u, Vector v)
{
    return (Vector){u.x + v.x, u.y + v.y, u.z + v.z};
}

static inline Vector subtract(Vector u, Vector v)
{
    return (Vector){u.x - v.x, u.y - v.y, u.z - v.z};
}

static inline Vector scale(double s, Vector v)
{
    return (Vector){s * v.x, s * v.y, s * v.z};
}

static inline double dot(Vector u, Vector v)
{
    return u.x * v.x + u.y * v.y + u.z * v.z;
}

static inline Vector cross(Vector u, Vector v)
{
    return (Vector){u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

static inline double norm(Vector v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z); /* a proof sees that no square is below 0 */
}

/* v over its length `size`, or against it where size is minus the length; no component is above 1, but by rounding. */
#ifdef PROOF_WITHIN_LIMITS
/*@ requires size >= 0x1p-537 || size <= -0x1p-537;
    assigns \result \from size, v;
    ensures -1.25 <= \result.x <= 1.25 && -1.25 <= \result.y <= 1.25 && -1.25 <= \result.z <= 1.25; */
#endif
static inline Vector direction(double size, Vector v)
{
    return scale(1.0 / size, v);
}

static inline bool is_finite(Vector v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* M v. */
static inline Vector apply(Matrix m, Vector v)
{
    return (Vector){dot(m.a, v), dot(m.b, v), dot(m.c, v)};
}

/* M^T v. */
static inline Vector apply_transposed(Matrix m, Vector v)
{
    return (Vector){m.a.x * v.x + m.b.x * v.y + m.c.x * v.z, m.a.y * v.x + m.b.y * v.y + m.c.y * v.z,
                    m.a.z * v.x + m.b.z * v.y + m.c.z * v.z};
}

static inline Matrix transposed(Matrix m)
{
    return (Matrix){{m.a.x, m.b.x, m.c.x}, {m.a.y, m.b.y, m.c.y}, {m.a.z, m.b.z, m.c.z}};
}

/* M N; of matrices that stay where they are, which saves a processor their copies. */
static inline Matrix product_of(const Matrix *m, const Matrix *n)
{
    return (Matrix){apply_transposed(*n, m->a), apply_transposed(*n, m->b), apply_transposed(*n, m->c)};
}

static inline Matrix multiply(Matrix m, Matrix n)
{
    return product_of(&m, &n);
}

/* v^, with v^ w = v x w. */
static inline Matrix hat(Vector v)
{
    return (Matrix){{0.0, -v.z, v.y}, {v.z, 0.0, -v.x}, {-v.y, v.x, 0.0}};
}

/* M + s N. */
static inline Matrix add_scaled(Matrix m, double s, Matrix n)
{
    return (Matrix){add(m.a, scale(s, n.a)), add(m.b, scale(s, n.b)), add(m.c, scale(s, n.c))};
}

static inline double determinant(Matrix m)
{
    return dot(m.a, cross(m.b, m.c));
}

/* M^-1 of a regular M. */
static inline Matrix inverse(Matrix m)
{
    const Vector u = cross(m.b, m.c), v = cross(m.c, m.a), w = cross(m.a, m.b);
    const double d = 1.0 / dot(m.a, u);
    return transposed((Matrix){scale(d, u), scale(d, v), scale(d, w)});
}

/* x with M x = y. */
static inline Vector solve(Matrix m, Vector y)
{
    const Vector u = cross(m.b, m.c), v = cross(m.c, m.a), w = cross(m.a, m.b);
    const Vector sum = add(scale(y.x, u), add(scale(y.y, v), scale(y.z, w)));
    return scale(1.0 / dot(m.a, u), sum);
}

static inline bool is_finite_matrix(Matrix m)
{
    return is_finite(m.a) && is_finite(m.b) && is_finite(m.c);
}

static inline double larger(double x, double y)
{
    return x > y ? x : y;
}

static inline double smaller(double x, double y)
{
    return x < y ? x : y;
}

/* x within [low, high]. */
static inline double clip(double x, double low, double high)
{
    return larger(smaller(x, high), low);
}

/* Into how many equal steps of at most `longest` a time of at least 0 falls; at most 1e9. */
static inline int steps_of(double time, double longest)
{
    const double steps = time / longest;
    if (!(steps == steps)) { /* no number; a proof sees it so, not by isnan */
        return 1;
    }
    if (steps > 1e9) {
        return 1000000000;
    }
    const int whole = (int)steps;
    return whole < steps ? whole + 1 : whole > 0 ? whole : 1;
}

/* The whole part of x, within 0 and `most`; 0 of what is no number. */
static inline int whole_part(double x, int most)
{
    if (!(x == x) || !(x > 0.0)) { /* a proof sees only the first as no number */
        return 0;
    }
    return x < most ? (int)x : most;
}

/* The largest |component|. */
static inline double largest(Vector v)
{
    return larger(larger(fabs(v.x), fabs(v.y)), fabs(v.z));
}

/* The largest |element|. */
static inline double largest_element(Matrix m)
{
    return larger(larger(largest(m.a), largest(m.b)), largest(m.c));
}

#endif
