/* Tests: tests/fmus/kit/test_example.py. */
#include "actuators.h"

#include <math.h>

#include "vector.h"

/* First, second and third rod, in body axes. */
static const double ROOT_THIRD = 0.5773502691896258;
static const double FIELD_MIN = 1e-9;    /* T; a weaker field has no direction */
static const double ON_WHEEL_MIN = 0.02; /* with the field this close to normal the wheel is left alone */
static const double REST = 0.5;          /* rad/s; a slower wheel gets no Coulomb compensation, which would chatter */

bool actuators_check(const ActuatorsParameters *p, Fault *f)
{
    if (!(p->off_time < p->cycle)) {
        return fault(f, "off_time", p->off_time, "less than cycle");
    }
    if (!(p->coil_step <= p->coil_max)) {
        return fault(f, "coil_step", p->coil_step, "at most coil_max");
    }
    return true;
}

void actuators_prepare(const ActuatorsParameters *p, ActuatorsLaw *law)
{
    law->p = *p;
}

bool actuators_start(const ActuatorsLaw *law, const ActuatorsInputs *u, ActuatorsState *x, Fault *f)
{
    (void)law, (void)u, (void)f;
    x->t = 0.0;
    return true;
}

static double limited(double x, double limit)
{
    return fmax(-limit, fmin(limit, x));
}

/* The last part of each period belongs to the magnetometer; half a millisecond takes in the rounding of t. */
static bool powered(const ActuatorsParameters *p, double t)
{
    return fmod(t + 5e-4, p->cycle) < p->cycle - p->off_time;
}

/* What a driver makes of a dipole, A m2. */
static double driven(const ActuatorsParameters *p, double dipole)
{
    const double step = 1e-3 * p->coil_step, harder = p->cycle / (p->cycle - p->off_time) * dipole;
    if (fabs(harder) < 1e-3 * p->coil_dead_band) {
        return 0.0;
    }
    return step > 0.0 ? step * floor(harder / step + 0.5) : harder;
}

/* Least-norm dipoles of the rods, A m2, whose torque across the field b is `across`, N m. */
static void dipoles(Vector across, Vector field, double m[3])
{
    const Vector u[3] = {{ROOT_THIRD, ROOT_THIRD, -ROOT_THIRD}, {ROOT_THIRD, -ROOT_THIRD, ROOT_THIRD}, {0.0, 0.0, 1.0}};
    const double B = norm(field);
    const Vector b = scale(1.0 / B, field);
    const Vector seed = fabs(b.x) < 0.6 ? (Vector){1.0, 0.0, 0.0} : (Vector){0.0, 1.0, 0.0};
    const Vector side = subtract(seed, scale(dot(seed, b), b));
    const Vector n = scale(1.0 / norm(side), side), c = cross(b, n);
    double nn = 0.0, nc = 0.0, cc = 0.0, rows[3][2];
    for (int i = 0; i < 3; ++i) {
        const Vector lever = cross(u[i], field);
        rows[i][0] = dot(lever, n);
        rows[i][1] = dot(lever, c);
        nn += rows[i][0] * rows[i][0];
        nc += rows[i][0] * rows[i][1];
        cc += rows[i][1] * rows[i][1];
    }
    const double det = nn * cc - nc * nc, tn = dot(across, n), tc = dot(across, c);
    for (int i = 0; i < 3; ++i) {
        m[i] = (rows[i][0] * (cc * tn - nc * tc) + rows[i][1] * (nn * tc - nc * tn)) / det;
    }
}

bool actuators_outputs(const ActuatorsLaw *law, const ActuatorsState *x, const ActuatorsInputs *u, ActuatorsOutputs *y,
                       Fault *f)
{
    const ActuatorsParameters *p = &law->p;
    const double PI = 3.14159265358979323846;
    const Vector field = {1e-9 * u->mag_y, -1e-9 * u->mag_x, 1e-9 * u->mag_z};
    const Vector gyro = scale(PI / 180.0, vector(u->gyro)), request = scale(1e-3, vector(u->torque_request));
    const double rate = PI / 30.0 * u->tach, momentum = 1e-7 * p->rotor_inertia * rate, B = norm(field);
    if (!(isfinite(B) && isfinite(norm(gyro)) && isfinite(norm(request)) && isfinite(rate))) {
        return fault(f, "inputs", NAN, "finite numbers");
    }
    y->coils_on = powered(p, x->t);
    if (B < FIELD_MIN) {
        return true; /* all commands zero */
    }
    const Vector b = scale(1.0 / B, field);
    y->field_on_wheel = b.x;

    /* The wheel gives what is asked for along the field, as far as it can; the coils the rest across it. */
    const Vector precession = {0.0, -gyro.z * momentum, gyro.y * momentum};
    const double along = dot(subtract(request, precession), b);
    const double spin = fabs(b.x) < ON_WHEEL_MIN ? 0.0 : limited(-along / b.x, 1e-3 * p->motor_max);
    const Vector wheel = add((Vector){-spin, 0.0, 0.0}, precession);
    double m[3];
    dipoles(subtract(request, wheel), field, m);
    const double largest_asked = fmax(fabs(m[0]), fmax(fabs(m[1]), fabs(m[2])));
    const double most = 1e-3 * p->coil_max * (p->cycle - p->off_time) / p->cycle;
    const double share = largest_asked > most ? most / largest_asked : 1.0; /* keeps the torque's direction */
    static const int rod_of[3] = {2, 0, 1};
    for (int i = 0; i < 3; ++i) {
        y->coil[i] = y->coils_on ? 1e3 * limited(driven(p, share * m[rod_of[i]]), 1e-3 * p->coil_max) : 0.0;
    }

    double friction = 1e-6 * p->friction_viscous * u->tach;
    if (fabs(rate) > REST) {
        friction += copysign(1e-3 * p->friction_coulomb, rate);
    }
    y->wheel_motor = -1e3 * limited(spin + friction, 1e-3 * p->motor_max);
    return true;
}

bool actuators_step(const ActuatorsLaw *law, ActuatorsState *x, const ActuatorsInputs *u, double h, ActuatorsOutputs *y,
                    Fault *f)
{
    ActuatorsState after = {x->t + h};
    *y = (ActuatorsOutputs){0};
    if (!actuators_outputs(law, &after, u, y, f)) {
        return false;
    }
    *x = after;
    return true;
}
