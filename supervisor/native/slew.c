#include "slew.h"

/* Of the quintic from rest to rest: largest rate in angle/T, largest acceleration in angle/T^2; and of the one that takes an
 * initial rate to zero, the largest acceleration in rate/T. */
static const double PEAK_RATE = 1.875, PEAK_CHANGE = 5.773502691896258, PEAK_CHANGE_OF_RATE = 3.9413;
static const double RATE_LEFT = 0.25; /* of the largest rate, which an initial rate leaves to the turn at least */
static const double SMALL = 0.05;     /* rad, below which the coefficients are taken from their series */

/* a = (1 - cos x)/x^2, b = (x - sin x)/x^3, a'/x and b'/x: of the right Jacobian I - a x^ + b x^^2. */
typedef struct {
    double a, b, da, db;
} Coefficients;

static Coefficients coefficients(double x)
{
    const double x2 = x * x;
    if (x < SMALL) {
        return (Coefficients){1.0 / 2.0 - x2 / 24.0 + x2 * x2 / 720.0, 1.0 / 6.0 - x2 / 120.0 + x2 * x2 / 5040.0,
                              -1.0 / 12.0 + x2 / 180.0 - x2 * x2 / 6720.0, -1.0 / 60.0 + x2 / 1260.0 - x2 * x2 / 60480.0};
    }
    const double s = sin(x), c = cos(x), a = (1.0 - c) / x2, b = (x - s) / (x2 * x);
    return (Coefficients){a, b, (s / x - 2.0 * a) / x2, (a - 3.0 * b) / x2};
}

/* (I - a phi^ + b phi^^2) v: d exp(phi^)/dt = exp(phi^) (this of dphi/dt)^. */
static Vector jacobian(const Coefficients *k, Vector phi, Vector v)
{
    const Vector across = cross(phi, v);
    return add(subtract(v, scale(k->a, across)), scale(k->b, cross(phi, across)));
}

/* v with jacobian v = w. */
static Vector jacobian_solve(const Coefficients *k, Vector phi, Vector w)
{
    const Vector x = jacobian(k, phi, (Vector){1.0, 0.0, 0.0}), y = jacobian(k, phi, (Vector){0.0, 1.0, 0.0}),
                 z = jacobian(k, phi, (Vector){0.0, 0.0, 1.0});
    return solve(transposed((Matrix){x, y, z}), w);
}

Slew supervisor_slew_begin(const Reference *now, const Reference *to, Matrix J, double rate_max, double torque_max)
{
    const Vector phi0 = rotation_log(multiply(transposed(to->R_d), now->R_d));
    const Coefficients k = coefficients(norm(phi0));
    const Vector rate0 = subtract(now->Omega_d, apply_transposed(rotation_exp(phi0), to->Omega_d));
    const Vector dphi0 = jacobian_solve(&k, phi0, rate0);
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
    const double g = x * (1.0 + x * x * (-6.0 + x * (8.0 - 3.0 * x))) * T, dg = 1.0 + x * x * (-18.0 + x * (32.0 - 15.0 * x)),
                 ddg = 12.0 * x * (-3.0 + x * (8.0 - 5.0 * x)) / T;
    const Vector phi = add(scale(f, slew->phi0), scale(g, slew->dphi0)),
                 dphi = add(scale(df, slew->phi0), scale(dg, slew->dphi0)),
                 ddphi = add(scale(ddf, slew->phi0), scale(ddg, slew->dphi0));
    const Coefficients k = coefficients(norm(phi));
    const Vector w = jacobian(&k, phi, dphi), across = cross(phi, dphi);
    const double along = dot(phi, dphi);
    /* d(jacobian)/dt dphi/dt; zero for a turn about one axis. */
    const Vector change =
        add(add(scale(-k.da * along, across), scale(k.db * along, cross(phi, across))), scale(k.b, cross(dphi, across)));
    const Matrix A = rotation_exp(phi);
    const Vector Omega = apply_transposed(A, to->Omega_d);
    const Vector dw = add(jacobian(&k, phi, ddphi), change);
    return (Reference){multiply(to->R_d, A), add(Omega, w), add(add(apply_transposed(A, to->dOmega_d), cross(Omega, w)), dw)};
}
