/* What the laws of several blocks need of a set of up to four reaction wheels and of the rods that unload them. */
#ifndef COMMON_WHEELS_H
#define COMMON_WHEELS_H

#include <stdint.h>

#include "rotation.h"

enum { WHEELS_MAX = 4 };

static const double WHEELS_FIELD_MIN = 1e-12; /* T; a weaker field counts as none */
/* Share of the mean stiffness of the wheels' axes below which a direction counts as one without wheels. */
static const double WHEELS_REGULAR = 1e-9;

/* Whether the wheels that there are have unit axes and limits above zero. */
static inline bool are_wheels(int32_t wheels, const double axes[WHEELS_MAX][3], const double torque_max[WHEELS_MAX],
                              const double momentum_max[WHEELS_MAX], Fault *f)
{
    static const char *const names[] = {"wheel_axis[1]", "wheel_axis[2]", "wheel_axis[3]", "wheel_axis[4]"};
    if (!(wheels >= 0 && wheels <= WHEELS_MAX)) {
        return fault(f, "wheels", wheels, "0 to 4");
    }
    for (int i = 0; i < wheels; ++i) {
        const Named positive[] = {{"wheel_torque_max", torque_max[i]}, {"wheel_momentum_max", momentum_max[i]}};
        if (!is_unit_vector(vector(axes[i]), names[i], f) || !all_positive(positive, COUNT(positive), f)) {
            return false;
        }
    }
    return true;
}

static inline bool are_wheel_momenta(const double h_w[WHEELS_MAX], Fault *f)
{
    static const char *const names[] = {"h_w[1]", "h_w[2]", "h_w[3]", "h_w[4]"};
    for (int i = 0; i < WHEELS_MAX; ++i) {
        const Named momentum = {names[i], h_w[i]};
        if (!all_finite(&momentum, 1, f)) {
            return false;
        }
    }
    return true;
}

/* Of all wheel torques that give a torque on the body the one with the least sum of (dl_i / torque_max_i)^2:
 * dl = -S^2 A^T (A S^2 A^T)^-1 tau, the axes being the columns of A: a row each. In a direction without wheels it gives
 * nothing; a wheel of limit zero takes no part. */
static inline void distribute(int wheels, const Vector axes[WHEELS_MAX], const double limits[WHEELS_MAX],
                              Vector share_of[WHEELS_MAX])
{
    Matrix stiffness = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int i = 0; i < wheels; ++i) {
        const Vector a = scale(limits[i], axes[i]);
        stiffness = add_scaled(stiffness, 1.0, (Matrix){scale(a.x, a), scale(a.y, a), scale(a.z, a)});
    }
    const double regular = WHEELS_REGULAR * (stiffness.a.x + stiffness.b.y + stiffness.c.z) / 3.0;
    stiffness.a.x += regular;
    stiffness.b.y += regular;
    stiffness.c.z += regular;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        share_of[i] = (Vector){0.0, 0.0, 0.0};
        if (i < wheels && limits[i] > 0.0) {
            share_of[i] = scale(-limits[i] * limits[i], solve(stiffness, axes[i]));
        }
    }
}

/* Along the rods, A m2: m = H x b/(T |b|^2), whose torque takes the momentum H across the field away in the time T; all
 * three smaller where one is at its limit. rods_inverse takes a dipole from body axes to the rods' axes. */
static inline Vector unloading(Matrix rods_inverse, double dipole_max, const double rod_limits[3], double T, Vector H,
                               Vector b)
{
    const double B = norm(b);
    if (B < WHEELS_FIELD_MIN) {
        return (Vector){0.0, 0.0, 0.0};
    }
    const Vector m = apply(rods_inverse, scale(1.0 / (T * B * B), cross(H, b)));
    const Vector limit = {rod_limits[0] * dipole_max, rod_limits[1] * dipole_max, rod_limits[2] * dipole_max};
    const double most = largest((Vector){m.x / limit.x, m.y / limit.y, m.z / limit.z});
    const Vector within = scale(most > 1.0 ? 1.0 / most : 1.0, m); /* but for rounding */
    return (Vector){clip(within.x, -limit.x, limit.x), clip(within.y, -limit.y, limit.y),
                    clip(within.z, -limit.z, limit.z)};
}

#endif
