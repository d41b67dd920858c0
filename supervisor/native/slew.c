/* A slew from rest to rest about one axis. Requirement: SV-2. */
#include "slew.h"

#include "jacobian.h"

/* Of the quintic from rest to rest: largest rate in angle/T, largest acceleration in angle/T^2; and of the one that
 * takes an initial rate to zero, the largest acceleration in rate/T. */
static const double PEAK_RATE = 1.875, PEAK_CHANGE = 5.773502691896258, PEAK_CHANGE_OF_RATE = 3.9413;
static const double RATE_LEFT = 0.25; /* of the largest rate, which an initial rate leaves to the turn at least */

Slew supervisor_slew_begin(const Reference *now, const Reference *to, Matrix J, double rate_max, double torque_max)
{
    const Vector phi0 = rotation_log(multiply(transposed(to->R_d), now->R_d));
    const RightJacobian k = right_jacobian_of(norm(phi0));
    const Vector rate0 = subtract(now->Omega_d, apply_transposed(rotation_exp(phi0), to->Omega_d));
    const Vector dphi0 = right_jacobian_solve(&k, phi0, rate0);
    const double turn = PEAK_CHANGE * norm(apply(J, phi0)), stop = PEAK_CHANGE_OF_RATE * norm(apply(J, dphi0));
    const double by_torque = (stop + sqrt(stop * stop + 4.0 * torque_max * turn)) / (2.0 * torque_max);
    const double by_rate = PEAK_RATE * norm(phi0) / larger(rate_max - norm(dphi0), RATE_LEFT * rate_max);
    return (Slew){larger(by_torque, by_rate), phi0, dphi0};
}

Reference supervisor_slew_at(const Slew *slew, double s, const Reference *to)
{
    const double T = slew->duration, x = s / T;
    if (s >= T) {
        return *to;
    }
    const double f = 1.0 + x * x * x * (-10.0 + x * (15.0 - 6.0 * x)), df = 30.0 * x * x * (-1.0 + x * (2.0 - x)) / T,
                 ddf = 60.0 * x * (-1.0 + x * (3.0 - 2.0 * x)) / (T * T);
    const double g = x * (1.0 + x * x * (-6.0 + x * (8.0 - 3.0 * x))) * T,
                 dg = 1.0 + x * x * (-18.0 + x * (32.0 - 15.0 * x)), ddg = 12.0 * x * (-3.0 + x * (8.0 - 5.0 * x)) / T;
    const Vector phi = add(scale(f, slew->phi0), scale(g, slew->dphi0)),
                 dphi = add(scale(df, slew->phi0), scale(dg, slew->dphi0)),
                 ddphi = add(scale(ddf, slew->phi0), scale(ddg, slew->dphi0));
    const RightJacobian k = right_jacobian_of(norm(phi));
    const Vector w = right_jacobian(&k, phi, dphi), across = cross(phi, dphi);
    const double along = dot(phi, dphi);
    /* d(jacobian)/dt dphi/dt; zero for a turn about one axis. */
    const Vector change = add(add(scale(-k.da * along, across), scale(k.db * along, cross(phi, across))),
                              scale(k.b, cross(dphi, across)));
    const Matrix A = rotation_exp(phi);
    const Vector Omega = apply_transposed(A, to->Omega_d);
    const Vector dw = add(right_jacobian(&k, phi, ddphi), change);
    return (Reference){multiply(to->R_d, A), add(Omega, w),
                       add(add(apply_transposed(A, to->dOmega_d), cross(Omega, w)), dw)};
}
