/* The desired motion that the parameters `reference`, `R_d0` and `Omega_d0` give, and their check. */
#ifndef COMMON_REFERENCE_H
#define COMMON_REFERENCE_H

#include <stdint.h>

#include "rotation.h"

/* Values of the parameter `reference`, as in the interfaces. */
enum { REFERENCE_LVLH = 1, REFERENCE_INERTIAL = 2, REFERENCE_RATE = 3 };

static const double REFERENCE_R_MIN = 1.0; /* m; nearer to the Earth's centre a position has no direction */
static const double REFERENCE_ATTITUDE_TOLERANCE = 1e-4;  /* of R_NB and R_d: single precision stays well below it */
static const double REFERENCE_PARAMETER_TOLERANCE = 1e-3; /* of R_d0, which may be typed from four printed decimals */
static const double REFERENCE_COLLINEAR = 1e-9;           /* |r x v|/(|r||v|) below which the orbit has no plane */
static const double REFERENCE_H_MIN = 1e-100;             /* m2/s; less is no motion, and has no direction */
static const double REFERENCE_NO_ATTITUDE =
    3.14159265358979323846; /* rad; the attitude error while there is no attitude */

/* Attitude (N from desired body), rate and its derivative in desired body axes [3]. */
typedef struct {
    Matrix R_d;
    Vector Omega_d, dOmega_d;
} Reference;

/* Whether `reference` is one of the three. */
static inline bool is_reference(int32_t reference, Fault *f)
{
    if (reference < REFERENCE_LVLH || reference > REFERENCE_RATE) {
        return fault(f, "reference", reference, "1 (lvlh), 2 (inertial) or 3 (rate)");
    }
    return true;
}

/* Whether R_d0 and Omega_d0 give an attitude and a rate. */
static inline bool is_reference_start(const double R_d0[3][3], const double Omega_d0[3], Fault *f)
{
    const NamedVector rate = {"Omega_d0", vector(Omega_d0)};
    return all_finite_vectors(&rate, 1, f) && is_rotation(matrix(R_d0), REFERENCE_PARAMETER_TOLERANCE, "R_d0",
                                                          "a rotation matrix, max |R_d0^T R_d0 - I| at most 0.001", f);
}

/* Whether R_NB is an attitude. */
static inline bool is_attitude(Matrix R_NB, Fault *f)
{
    return is_rotation(R_NB, REFERENCE_ATTITUDE_TOLERANCE, "R_NB",
                       "a rotation matrix, max |R_NB^T R_NB - I| at most 0.0001", f);
}

/* Whether the inputs that every reference may need are finite. */
static inline bool are_finite_rate_and_orbit(const double omega_B[3], const double r_N[3], const double v_N[3],
                                             Fault *f)
{
    const NamedVector inputs[] = {{"omega_B", vector(omega_B)}, {"r_N", vector(r_N)}, {"v_N", vector(v_N)}};
    return all_finite_vectors(inputs, COUNT(inputs), f);
}

/* LVLH: Z to nadir, Y = -orbit normal, X = Y x Z; any orbit, not only a circle: n = |r x v|/r^2, and since |r x v|
 * is constant dn/dt = -2 n (r.v)/r^2. */
static inline bool reference_lvlh(Vector r_N, Vector v_N, Reference *reference, Fault *f)
{
    const double r = norm(r_N);
    const Vector h_N = cross(r_N, v_N);
    const double h = norm(h_N);
    if (r < REFERENCE_R_MIN) {
        return fault(f, "r_N", r, "at least 1 m from the Earth's centre, for the reference 'lvlh'");
    }
    if (!(h > larger(REFERENCE_COLLINEAR * r * norm(v_N), REFERENCE_H_MIN))) {
        return fault(f, "v_N", h,
                     "a velocity that spans the orbit's plane with r_N, |r x v| above 0, for the reference 'lvlh'");
    }
    const double n = h / (r * r);
    const double dn = -2.0 * n * dot(r_N, v_N) / (r * r);
    *reference = (Reference){lvlh_of(r_N, r, h_N, h), {0.0, -n, 0.0}, {0.0, -dn, 0.0}};
    return true;
}

/* At t s after the start: R_d0 relative to LVLH of r_N and v_N; R_d0 at rest; or R_d0 that turns with Omega_d0. */
static inline bool reference_at(int32_t kind, Matrix R_d0, Vector Omega_d0, double t, Vector r_N, Vector v_N,
                                Reference *reference, Fault *f)
{
    const Vector rest = {0.0, 0.0, 0.0};
    switch (kind) {
    case REFERENCE_LVLH:
        if (!reference_lvlh(r_N, v_N, reference, f)) {
            return false;
        }
        *reference = (Reference){multiply(reference->R_d, R_d0), apply_transposed(R_d0, reference->Omega_d),
                                 apply_transposed(R_d0, reference->dOmega_d)};
        return true;
    case REFERENCE_RATE:
        *reference = (Reference){multiply(R_d0, rotation_exp(scale(t, Omega_d0))), Omega_d0, rest};
        return true;
    default:
        *reference = (Reference){R_d0, rest, rest};
        return true;
    }
}

#endif
