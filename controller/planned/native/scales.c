/* docs/how/planned-scales.md, Any satellite. Tests: test_scales.py. */
#include "scales.h"

#include "onboard_field.h"
#include "rotation.h"

/* B at the Earth's surface, T: that of the Earth's dipole near the poles, where it is 2.0 times the 3.0e-5 of the
 * equator. */
static const double SURFACE_FIELD = 5.77e-5;

/* Times in T, rates in 1/T, momenta in J/T, torques in J/T^2. */
static const double STIFFNESS = 0.45, DAMPING = 0.9; /* of the law [8]: damped by half, in T/0.67 */
static const double DAMPING_SAMPLED = 0.5; /* of the least moment over the period: half of what is stable at once */
static const double UNEVEN = 10.0;         /* the stiffness is K -+ K/10, so that critical points are apart [9] */
static const double STEERING_LIMIT = 3.0;
static const double SLENDER = 10.0; /* of the least moment of inertia: the mean one counts as no more than this */
static const double NUTATION = 1.0; /* from which it is fast */
static const double DISTURBANCE_MAX = 0.036; /* of the rods' torque: more could not be opposed by rods in the hold */
static const double STRAINED_DISTURBANCE = 4.0,
                    STRAINED_SOONER = 10.0;                      /* in a strained hold: more, and forgotten sooner */
static const double RESIDUAL_DIPOLE_MAX = 0.05;                  /* of dipole_max */
static const double FORGOTTEN = 400.0, SOONER_FORGOTTEN = 100.0; /* s */
static const double STRONG_DRAG = 370e3;                         /* m, the height below which drag is strong */
static const double DENSITY_HEIGHT = 60e3; /* m, in which the density of the air falls by e there */
static const double WEIGHT_ANGLE = 10.0, WEIGHT_CONTROL = 0.005;
static const double FINAL = 6.0, FINAL_WHEEL = 0.6;                /* by which the last stage counts */
static const double WEIGHT_RATE = 0.8;                             /* T^2 */
static const double WHEEL_MOMENTUM = 10.0;                         /* more than this takes the rods very long to undo */
static const double WHEEL_NEAR_LIMIT = 0.8667;                     /* of what the wheel is let hold */
static const double WEIGHT_WHEEL_NEAR_LIMIT = 270.0;               /* over its square */
static const double WEIGHT_RODS = 8.25e-5, WEIGHT_MOTOR = 4.12e-3; /* (J/T^2)^2 */

/* To two digits: that is what these multiples are known to, and rounding elsewhere then changes none of them. */
static double two_digits(double x)
{
    double shift = 1.0;
    if (!(x > 1e-18 && x < 1e18)) {
        return x;
    }
    while (x * shift < 10.0) {
        shift *= 10.0;
    }
    if (shift > 1.0) {
        return whole_part(x * shift + 0.5, 100) / shift;
    }
    while (x / shift >= 100.0) {
        shift *= 10.0;
    }
    return whole_part(x / shift + 0.5, 100) * shift;
}

bool controller_planned_has_L0(const ControllerPlannedParameters *p)
{
    return !is_zero_matrix(matrix(p->L0));
}

bool controller_planned_has_K0(const ControllerPlannedParameters *p)
{
    return p->K0[0] != 0.0 || p->K0[1] != 0.0 || p->K0[2] != 0.0;
}

static double given_or(double given, double computed)
{
    return given > 0.0 ? given : computed;
}

/* s: the sooner where drag is strong, since it changes along the orbit. */
static double drag_forgotten(double a)
{
    return clip(SOONER_FORGOTTEN * exp((a - ONBOARD_RADIUS - STRONG_DRAG) / DENSITY_HEIGHT), SOONER_FORGOTTEN,
                FORGOTTEN);
}

enum { POWERS = 200 };

double controller_planned_largest_of(Matrix J, Matrix S)
{
    const Matrix M = multiply(inverse(J), S);
    Vector v = {1.0, 0.9, 1.1};
    for (int i = 0; i < POWERS; ++i) {
        const Vector w = apply(M, v);
        v = scale(1.0 / larger(norm(w), 1e-300), w);
    }
    return dot(v, apply(M, v));
}

/* rad/s, of a body with a wheel whose momentum is l along the axis a: the eigenvalues of J^-1 (l a)^ are 0 and +-i
 * times it. */
static double nutation(Matrix J, Vector a, double l)
{
    return l * sqrt(dot(a, apply(J, a)) / determinant(J));
}

Vector controller_planned_rod_dipoles(const ControllerPlannedParameters *p)
{
    return scale(p->dipole_max, vector(p->rod_limits));
}

double controller_planned_rods_share(const ControllerPlannedParameters *p, const double gains[3])
{
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        sum += p->rod_limits[i] * fabs(gains[i]);
    }
    return sum / 3.0;
}

Scales controller_planned_scales(const ControllerPlannedParameters *p, double a)
{
    const Matrix J = matrix(p->J_B);
    const double least = 1.0 / controller_planned_largest_of(J, identity), mean = (J.a.x + J.b.y + J.c.z) / 3.0;
    const double inertia = smaller(mean, SLENDER * least), ratio = ONBOARD_RADIUS / a;
    static const double sound[3] = {1.0, 1.0, 1.0};
    const double dipole = p->dipole_max * controller_planned_rods_share(p, sound);
    const double T = two_digits(sqrt(inertia / (dipole * SURFACE_FIELD * ratio * ratio * ratio)));
    const double momentum = inertia / T, torque = momentum / T;
    const double h = smaller(p->wheel_momentum_max, WHEEL_MOMENTUM * momentum);
    const double k = two_digits(STIFFNESS * torque);
    const double disturbance = p->disturbance_max >= 0.0 ? p->disturbance_max : two_digits(DISTURBANCE_MAX * torque);
    const double forgotten = given_or(p->disturbance_time, two_digits(drag_forgotten(a)));
    const double l = two_digits(smaller(DAMPING * momentum, DAMPING_SAMPLED * least / p->control_period));
    const double rate = sqrt(p->gravitational_parameter / (a * a * a));
    return (Scales){
        .time = T,
        .momentum = momentum,
        .orbit_rate = rate,
        .period = ONBOARD_TURN / rate,
        .turning_moment = larger(least, mean / SLENDER),
        .torque = torque,
        .fast_nutation = nutation(J, vector(p->wheel_axis), p->wheel_momentum_max) > NUTATION / T,
        .weight_angle = WEIGHT_ANGLE,
        .weight_rate = WEIGHT_RATE * T * T,
        .weight_control = WEIGHT_CONTROL,
        .weight_motor_control = WEIGHT_CONTROL,
        .final_errors = FINAL * T,
        .final_wheel = FINAL_WHEEL * T,
        .weight_wheel = two_digits(p->momentum_weight / (h * h)),
        .weight_near_limit = two_digits(WEIGHT_WHEEL_NEAR_LIMIT / (h * h)),
        .wheel_momentum = h,
        .near_limit = WHEEL_NEAR_LIMIT * h,
        .weight_rods = two_digits(WEIGHT_RODS * torque * torque),
        .weight_motor = two_digits(WEIGHT_MOTOR * torque * torque),
        .K = {k - k / UNEVEN, k, k + k / UNEVEN},
        .L = {{l, 0.0, 0.0}, {0.0, l, 0.0}, {0.0, 0.0, l}},
        .plan_period = given_or(p->plan_period, PLAN_PERIOD * T),
        .steering_limit = given_or(p->steering_limit, two_digits(STEERING_LIMIT * momentum)),
        .disturbance_max = disturbance,
        .strained_disturbance_max = p->disturbance_max >= 0.0 ? disturbance : STRAINED_DISTURBANCE * disturbance,
        .disturbance_time = forgotten,
        .strained_disturbance_time = p->disturbance_time > 0.0 ? forgotten : forgotten / STRAINED_SOONER,
        .residual_dipole_max = p->residual_dipole_max >= 0.0 ? p->residual_dipole_max : RESIDUAL_DIPOLE_MAX * dipole,
    };
}
