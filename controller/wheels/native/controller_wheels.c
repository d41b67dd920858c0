/* Tests: tests/controller/wheels/test_controller_wheels.py. */
#include "controller_wheels.h"

#include "controller_wheels_guard.h"
#include "reference.h"

typedef struct {
    Vector zeta;       /* rotation vector of the attitude error, R = R_d exp(zeta^), rad; zero without an attitude */
    double angle;      /* its length; pi without an attitude */
    Vector omega;      /* rate error */
    Vector dOmega_d_B; /* derivative of the desired rate as the turning body sees it, rad/s2 */
} Errors;

static bool errors_of(const ControllerWheelsLaw *law, double t, const ControllerWheelsInputs *u, Errors *e, Fault *f)
{
    const NamedVector given[] = {{"b_B", vector(u->b_B)}};
    const Matrix R = matrix(u->R_NB);
    Reference reference;
    if (!are_wheel_momenta(u->h_w, f) || !all_finite_vectors(given, COUNT(given), f) ||
        !are_finite_rate_and_orbit(u->omega_B, u->r_N, u->v_N, f) || (!is_zero_matrix(R) && !is_attitude(R, f)) ||
        !reference_at(law->p.reference, law->R_d0, vector(law->p.Omega_d0), t, vector(u->r_N), vector(u->v_N),
                      &reference, f)) {
        return false;
    }
    if (is_zero_matrix(R)) { /* no attitude: the rate alone is damped */
        *e = (Errors){.angle = 3.14159265358979323846, .omega = vector(u->omega_B)};
        return true;
    }
    const Matrix Q = multiply(transposed(reference.R_d), R);
    const Vector Omega_d_B = apply_transposed(Q, reference.Omega_d);
    e->zeta = rotation_log(Q);
    e->angle = norm(e->zeta);
    e->omega = subtract(vector(u->omega_B), Omega_d_B);
    e->dOmega_d_B = subtract(apply_transposed(Q, reference.dOmega_d), cross(e->omega, Omega_d_B));
    return true;
}

/* The largest of |x_i| / limit_i over the wheels, x_i their parts of a body vector. */
static double fraction(const ControllerWheelsLaw *law, Vector of_body, const double limit[WHEELS_MAX])
{
    double found = 0.0;
    for (int i = 0; i < law->p.wheels; ++i) {
        found = larger(found, fabs(dot(law->share_of[i], of_body)) / limit[i]);
    }
    return found;
}

/* Angular acceleration that the body should have. The rate towards the desired attitude is k |zeta| next to it; from
 * |zeta| = a/k^2 on it is that from which the deceleration a stops it there; and it has a limit. */
static Vector acceleration(const ControllerWheelsLaw *law, const Errors *e)
{
    const double k = law->p.bandwidth, gain = 4.0 * k; /* of the rate: critically damped with k */
    Vector wanted = {0.0, 0.0, 0.0}, change = {0.0, 0.0, 0.0};
    if (e->angle > 0.0) {
        const Vector axis = scale(1.0 / e->angle, e->zeta), along = apply(law->J, axis);
        const double torque = fraction(law, along, law->p.wheel_torque_max);
        const double momentum = fraction(law, along, law->p.wheel_momentum_max);
        double rate = k * e->angle, slope = k;
        if (torque > 0.0) { /* else no wheel limits it, nor acts */
            const double a = law->p.torque_share / torque;
            if (e->angle > a / (k * k)) {
                rate = sqrt(2.0 * a * e->angle - a * a / (k * k));
                slope = a / rate;
            }
            const double most = law->p.momentum_share / momentum;
            if (rate > most) {
                rate = most;
                slope = 0.0;
            }
        }
        wanted = scale(-rate, axis);
        change = scale(-slope * dot(axis, e->omega), axis);
    }
    return add(add(e->dOmega_d_B, change), scale(gain, subtract(wanted, e->omega)));
}

static bool outputs_of(const ControllerWheelsLaw *law, const ControllerWheelsState *x, const ControllerWheelsInputs *u,
                       ControllerWheelsOutputs *y, Fault *f)
{
    const ControllerWheelsParameters *p = &law->p;
    Errors e;
    if (!errors_of(law, x->t, u, &e, f)) {
        return false;
    }
    const Vector Omega = vector(u->omega_B), b = vector(u->b_B);
    Vector h = {0.0, 0.0, 0.0};
    for (int i = 0; i < p->wheels; ++i) {
        h = add(h, scale(u->h_w[i], law->axes[i]));
    }
    const Vector dipole = unloading(law->rods_inverse, p->dipole_max, p->rod_limits, p->unloading_time,
                                    add(apply(law->J, e.omega), h), b);
    const Vector by_rods = cross(apply(transposed(with_unit_rows(matrix(p->rod_axes))), dipole), b);
    const Vector gyroscopic = cross(Omega, add(apply(law->J, Omega), h));
    const Vector tau = subtract(add(apply(law->J, acceleration(law, &e)), gyroscopic), by_rods);

    const double demand = fraction(law, tau, p->wheel_torque_max), less = demand > 1.0 ? 1.0 / demand : 1.0;
    for (int i = 0; i < WHEELS_MAX; ++i) {
        y->wheel_torque_cmd[i] = 0.0;
        if (i < p->wheels) { /* within its momentum over a period; zero is always allowed */
            const double low = smaller((-p->wheel_momentum_max[i] - u->h_w[i]) / p->command_period, 0.0);
            const double high = larger((p->wheel_momentum_max[i] - u->h_w[i]) / p->command_period, 0.0);
            const double most = p->wheel_torque_max[i], torque = clip(less * dot(law->share_of[i], tau), -most, most);
            y->wheel_torque_cmd[i] = clip(torque, low, high);
        }
    }
    store(dipole, y->dipole_cmd);
    y->attitude_error = e.angle;
    store(e.omega, y->rate_error_B);
    y->demand_fraction = smaller(demand, 1e6);
    return true;
}

/*@ requires \separated(x, y, f);
    CONTROLLER_WHEELS_FINITE */
bool controller_wheels_outputs(const ControllerWheelsLaw *law, const ControllerWheelsState *x,
                               const ControllerWheelsInputs *u, ControllerWheelsOutputs *y, Fault *f)
{
    return outputs_of(law, x, u, y, f) && controller_wheels_guard(y, f);
}

bool controller_wheels_start(const ControllerWheelsLaw *law, const ControllerWheelsInputs *u, ControllerWheelsState *x,
                             Fault *f)
{
    const ControllerWheelsState now = {0.0};
    ControllerWheelsOutputs y;
    if (!controller_wheels_outputs(law, &now, u, &y, f)) {
        return false;
    }
    *x = now;
    return true;
}

/*@ requires \separated(x, y, f);
    CONTROLLER_WHEELS_FINITE */
bool controller_wheels_step(const ControllerWheelsLaw *law, ControllerWheelsState *x, const ControllerWheelsInputs *u,
                            double h, ControllerWheelsOutputs *y, Fault *f)
{
    const ControllerWheelsState next = {x->t + h};
    if (!controller_wheels_outputs(law, &next, u, y, f)) {
        return false;
    }
    *x = next;
    return true;
}
