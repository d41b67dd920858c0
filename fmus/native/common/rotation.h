/* Rotations and the checks of matrices that the blocks share.
 * Longer than 250 lines: contracts for the proofs stand beside their functions. */
#ifndef COMMON_ROTATION_H
#define COMMON_ROTATION_H

#include "fault.h"
#include "vector.h"

typedef struct {
    const char *name;
    Vector value;
} NamedVector;

/* Whether each vector has finite components. */
static inline bool all_finite_vectors(const NamedVector *vectors, size_t n, Fault *f)
{
    for (size_t i = 0; i < n; ++i) {
        if (!is_finite(vectors[i].value)) {
            return fault(f, vectors[i].name, NAN, "finite numbers");
        }
    }
    return true;
}

static const Matrix identity = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

/* exp(x^), the turn by |x| about x: cos(a) I + sin(a)/a x^ + (1 - cos a)/a^2 x x^T.
 * The factors are written with sin(a/2)/(a/2), so nothing cancels at small a. */
static inline Matrix rotation_exp(Vector x)
{
    const double half = 0.5 * norm(x);
    const double sinc = half > 1e-100 ? sin(half) / half : 1.0; /* 1 below, too */
#ifdef PROOF_WITHIN_LIMITS
    //@ assert sinc: -1.0 <= sinc <= 1.0;
#endif
    const double s = sinc * cos(half);
    const double c = 0.5 * sinc * sinc;
    const double diagonal = 1.0 - c * dot(x, x);
    return (Matrix){{diagonal + c * x.x * x.x, c * x.x * x.y - s * x.z, c * x.x * x.z + s * x.y},
                    {c * x.y * x.x + s * x.z, diagonal + c * x.y * x.y, c * x.y * x.z - s * x.x},
                    {c * x.z * x.x - s * x.y, c * x.z * x.y + s * x.x, diagonal + c * x.z * x.z}};
}

/* |zeta| of Q = exp(zeta^), rad in [0, pi], from sine and cosine together: good to all digits at 0 and at pi. */
static inline double principal_angle(Matrix Q)
{
    const Vector axis = {Q.c.y - Q.b.z, Q.a.z - Q.c.x, Q.b.x - Q.a.y};
    const double angle = atan2(0.5 * norm(axis), 0.5 * (Q.a.x + Q.b.y + Q.c.z - 1.0));
    return larger(angle, 0.0); /* it is not below: so a proof sees it, too */
}

/* zeta with R = exp(zeta^), |zeta| at most pi. */
static inline Vector rotation_log(Matrix R)
{
    const Vector twice = {R.c.y - R.b.z, R.a.z - R.c.x, R.b.x - R.a.y}; /* 2 sin(angle) axis */
    const double s = 0.5 * norm(twice), c = 0.5 * (R.a.x + R.b.y + R.c.z - 1.0);
    const double angle = atan2(s, c);
    if (s > 1e-4) { /* neither near 0 nor near pi */
        return scale(0.5 * angle / s, twice);
    }
    if (c > 0.0) {
        return scale(0.5, twice);
    }
    /* Near a half turn the axis comes from (R + R^T)/2 - c I = (1 - c) axis axis^T, by its largest column. */
    const double xy = 0.5 * (R.a.y + R.b.x), yz = 0.5 * (R.b.z + R.c.y), zx = 0.5 * (R.c.x + R.a.z);
    const Vector columns[3] = {{R.a.x - c, xy, zx}, {xy, R.b.y - c, yz}, {zx, yz, R.c.z - c}};
    Vector axis = columns[0];
    for (int i = 1; i < 3; ++i) {
        axis = dot(columns[i], columns[i]) > dot(axis, axis) ? columns[i] : axis;
    }
    const double sign = dot(axis, twice) < 0.0 ? -1.0 : 1.0;
    return scale(sign * angle / norm(axis), axis);
}

/* The rotation nearest to a matrix that is_rotation to 1e-3: its polar factor, by Newton's X <- (X + X^-T)/2. */
#ifdef PROOF_WITHIN_LIMITS
/*@ assigns \result \from X;
    ensures \is_finite(\result.a.x) && \is_finite(\result.a.y) && \is_finite(\result.a.z);
    ensures -1.01 <= \result.a.x <= 1.01 && -1.01 <= \result.a.y <= 1.01 && -1.01 <= \result.a.z <= 1.01;
    ensures \is_finite(\result.b.x) && \is_finite(\result.b.y) && \is_finite(\result.b.z);
    ensures -1.01 <= \result.b.x <= 1.01 && -1.01 <= \result.b.y <= 1.01 && -1.01 <= \result.b.z <= 1.01;
    ensures \is_finite(\result.c.x) && \is_finite(\result.c.y) && \is_finite(\result.c.z);
    ensures -1.01 <= \result.c.x <= 1.01 && -1.01 <= \result.c.y <= 1.01 && -1.01 <= \result.c.z <= 1.01; */
#endif
static inline Matrix nearest_rotation(Matrix X)
{
    for (int i = 0; i < 6; ++i) {
        const Matrix Y = transposed(inverse(X));
        X.a = scale(0.5, add(X.a, Y.a));
        X.b = scale(0.5, add(X.b, Y.b));
        X.c = scale(0.5, add(X.c, Y.c));
    }
    return X;
}

/* max |R^T R - I|; NaN where an element is. */
static inline double orthonormality_error(Matrix R)
{
    const Matrix C = transposed(R);
    const Vector off = {dot(C.a, C.b), dot(C.b, C.c), dot(C.c, C.a)};
    const Vector unit = {dot(C.a, C.a) - 1.0, dot(C.b, C.b) - 1.0, dot(C.c, C.c) - 1.0};
    return is_finite(off) && is_finite(unit) ? larger(largest(off), largest(unit)) : NAN;
}

/* Whether R is a rotation, to `tolerance` element by element of R^T R - I; the fault names the matrix and
 * `expected`. */
static inline bool is_rotation(Matrix R, double tolerance, const char *name, const char *expected, Fault *f)
{
    const double error = orthonormality_error(R);
    if (!(error <= tolerance)) {
        return fault(f, name, error, expected);
    }
    if (determinant(R) < 0.0) {
        return fault(f, name, determinant(R), "a rotation matrix, determinant +1 (this is a reflection)");
    }
    return true;
}

/* Zero in every element: an attitude of a master that has none yet. */
static inline bool is_zero_matrix(Matrix M)
{
    const Vector rows[] = {M.a, M.b, M.c};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        sum += fabs(rows[i].x) + fabs(rows[i].y) + fabs(rows[i].z);
    }
    return sum == 0.0; /* not of a NaN */
}

/* Whether S is symmetric to 1e-9 of its largest element and positive definite (leading minors). */
static inline bool is_positive_definite(Matrix S, const char *name, Fault *f)
{
    if (!is_finite_matrix(S)) {
        return fault(f, name, NAN, "finite numbers");
    }
    const double skew = larger(fabs(S.a.y - S.b.x), larger(fabs(S.b.z - S.c.y), fabs(S.c.x - S.a.z)));
    if (skew > 1e-9 * largest_element(S)) {
        return fault(f, name, skew, "a symmetric matrix, max |S - S^T| at most 1e-9 of its largest element");
    }
    const double minors[3] = {S.a.x, S.a.x * S.b.y - S.a.y * S.b.x, determinant(S)};
    for (int i = 0; i < 3; ++i) {
        if (!(minors[i] > 0.0)) {
            return fault(f, name, minors[i], "a positive definite matrix, each leading minor above 0");
        }
    }
    return true;
}

/* Whether J is the inertia of a body: positive definite, and no principal moment above the sum of the others
 * (to 1e-9 of it), that is c I - J positive definite with c next to half the trace. */
static inline bool is_inertia(Matrix J, const char *name, Fault *f)
{
    if (!is_positive_definite(J, name, f)) {
        return false;
    }
    const double c = (J.a.x + J.b.y + J.c.z) * (1.0 + 1e-9) / (2.0 + 1e-9);
    const Matrix D = {{c - J.a.x, -J.a.y, -J.a.z}, {-J.b.x, c - J.b.y, -J.b.z}, {-J.c.x, -J.c.y, c - J.c.z}};
    const double minors[3] = {D.a.x, D.a.x * D.b.y - D.a.y * D.b.x, determinant(D)};
    for (int i = 0; i < 3; ++i) {
        if (!(minors[i] > 0.0)) {
            return fault(f, name, minors[i],
                         "the inertia of a body, each principal moment at most the sum of the other two, "
                         "so that each leading minor of tr(J)/2 I - J is above 0");
        }
    }
    return true;
}

/* v scaled to unit length, of a vector whose length is 1 to 1e-6: the clip acts on no other. */
static inline Vector unit_vector(Vector v)
{
    return scale(1.0 / clip(norm(v), 0.5, 2.0), v);
}

/* The matrix with its rows scaled to unit length, of a matrix whose rows have it to 1e-6. */
static inline Matrix with_unit_rows(Matrix U)
{
    return (Matrix){unit_vector(U.a), unit_vector(U.b), unit_vector(U.c)};
}

/* LVLH as columns: Z to nadir, Y = -orbit normal, X = Y x Z; of a position in N, the normal h = r x v, and their lengths. */
static inline Matrix lvlh_of(Vector r_N, double r, Vector h_N, double h)
{
    const Vector z = direction(-r, r_N), y = direction(-h, h_N);
    return transposed((Matrix){cross(y, z), y, z});
}

/* The same of a position and a velocity in N. */
static inline Matrix lvlh_axes(Vector r_N, Vector v_N)
{
    const Vector h = cross(r_N, v_N);
    return lvlh_of(r_N, norm(r_N), h, norm(h));
}

/* Whether the rows are unit vectors, to 1e-6. */
static inline bool has_unit_rows(Matrix U, const char *name, Fault *f)
{
    const double lengths[3] = {norm(U.a), norm(U.b), norm(U.c)};
    for (int i = 0; i < 3; ++i) {
        if (!(fabs(lengths[i] - 1.0) <= 1e-6)) {
            return fault(f, name, lengths[i], "rows of unit length, to 1e-06");
        }
    }
    return true;
}

/* Whether v is of unit length, to 1e-6. */
static inline bool is_unit_vector(Vector v, const char *name, Fault *f)
{
    const double length = norm(v);
    return fabs(length - 1.0) <= 1e-6 || fault(f, name, length, "a vector of unit length, to 1e-06");
}

/* Whether the rows are unit vectors that do not lie in one plane. */
static inline bool has_independent_unit_rows(Matrix U, const char *name, Fault *f)
{
    if (!has_unit_rows(U, name, f)) {
        return false;
    }
    const double volume = determinant(U);
    if (!(fabs(volume) > 1e-6)) {
        return fault(f, name, volume, "linearly independent axes, |det| above 1e-06");
    }
    return true;
}

/* Whether each is the share of dipole_max that a rod gives at most. */
static inline bool are_rod_limits(const double rod_limits[3], Fault *f)
{
    static const char *const names[] = {"rod_limits[1]", "rod_limits[2]", "rod_limits[3]"};
    for (int i = 0; i < 3; ++i) {
        if (!(rod_limits[i] >= 0.01 && rod_limits[i] <= 1.0)) {
            return fault(f, names[i], rod_limits[i], "0.01 to 1");
        }
    }
    return true;
}

/* Whether K0 is the diagonal of a gain of the law [8]: no two elements alike, so that its critical points are apart
 * [9]. */
static inline bool is_ascending(const double K0[3], Fault *f)
{
    static const char *const order = "0 < K0[1] < K0[2] < K0[3], finite";
    if (!(K0[0] > 0.0)) {
        return fault(f, "K0[1]", K0[0], order);
    }
    if (!(K0[1] > K0[0])) {
        return fault(f, "K0[2]", K0[1], order);
    }
    if (!(K0[2] > K0[1] && isfinite(K0[2]))) {
        return fault(f, "K0[3]", K0[2], order);
    }
    return true;
}

#endif
