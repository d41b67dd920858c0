/* Wheels that leave a direction out: the plan of controller_planned for one of them, or for none; those beside it are
 * brought to rest. docs/how/planned-wheels.md, Failures. */
#include <string.h>

#include "sample.h"

/* Samples, in which a wheel beside it comes to rest; of the rods' torque in a usual field, T, what that takes at most. */
static const double REST_SAMPLES = 10.0, RODS_SHARE = 0.3, RODS_FIELD = 3e-5;
static const double NO_WHEEL = 1e-9; /* N m and N m s: of a satellite without wheel */

int32_t controller_planned_wheels_few(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                      const ControllerPlannedWheelsState *x)
{
    int32_t few = WHEELS_MAX + 1;
    double most = -1.0;
    for (int i = 0; i < law->p.wheels; ++i) {
        const double part = x->few == i + 1 ? INFINITY : dot(law->axes[i], apply(x->along, law->axes[i]));
        if (s->works[i] && part > most) {
            most = part;
            few = i + 1;
        }
    }
    return s->reduced ? few : 0;
}

ControllerPlannedParameters controller_planned_wheels_few_parameters(const ControllerPlannedWheelsParameters *p,
                                                                     int32_t few)
{
    /* Those that the block does not have are at the start values of controller_planned. */
    ControllerPlannedParameters of = {.search_iterations = 20,
                                      .momentum_weight = 0.018,
                                      .attitude_noise = 1.75e-4,
                                      .rate_noise = 1e-5,
                                      .disturbance_max = -1.0,
                                      .residual_dipole_max = -1.0,
                                      .rate_bias_max = 5e-4,
                                      .identify = true,
                                      .identify_spread = 0.08,
                                      .find_failures = true,
                                      .gravitational_parameter = 3.986004418e14,
                                      .field_model = CONTROLLER_PLANNED_FIELD_MODEL_IGRF14,
                                      .field_degree = 10};
    store_matrix(matrix(p->J_B), of.J_B);
    store_matrix(matrix(p->rod_axes), of.rod_axes);
    store_matrix(matrix(p->R_d0), of.R_d0);
    store((Vector){1.0, 1.0, 1.0}, of.rod_gains0);
    store(vector(p->rod_limits), of.rod_limits);
    of.dipole_max = p->dipole_max;
    of.control_period = p->command_period;
    of.wheel_axis[0] = 1.0;
    of.wheel_torque_max = of.wheel_momentum_max = NO_WHEEL;
    if (few <= WHEELS_MAX) {
        store(unit_vector(vector(p->wheel_axis[few - 1])), of.wheel_axis);
        of.wheel_torque_max = p->wheel_torque_max[few - 1];
        of.wheel_momentum_max = p->wheel_momentum_max[few - 1];
    }
    of.reference = p->reference;
    (void)memcpy(of.epoch, p->epoch, sizeof of.epoch);
    return of;
}

/* What the plan sees: the field, the orbit, and the wheel that works. That gave what was asked for: the friction that
 * the command has beside it is the allocator's. */
ControllerPlannedInputs controller_planned_wheels_seen(const ControllerPlannedWheelsInputs *u,
                                                       const ControllerPlannedWheelsState *x, int32_t few)
{
    static const double absent = 1e9; /* not connected */
    ControllerPlannedInputs of = {.attitude_bound = absent, .rate_health = -1, .field_health = -1};
    store_matrix(matrix(u->R_NB), of.R_NB);
    store(vector(u->omega_B), of.omega_B);
    store(vector(u->r_N), of.r_N);
    store(vector(u->v_N), of.v_N);
    store(vector(u->b_B), of.b_B);
    store((Vector){absent, absent, absent}, of.attitude_sigma_B);
    of.h_w = few <= WHEELS_MAX ? u->h_w[few - 1] : 0.0;
    store(vector(u->dipole_applied), of.u_applied);
    of.u_applied[3] = controller_planned_wheels_has_dipole_applied(u) ? x->planned.held.wheel_torque_ff : absent;
    store_matrix(matrix(u->R_ref), of.R_ref);
    store(vector(u->Omega_ref), of.Omega_ref);
    store(vector(u->dOmega_ref), of.dOmega_ref);
    if (is_zero_matrix(matrix(u->R_NB)) && !controller_planned_wheels_has_R_ref(u)) { /* no attitude, no reference */
        (void)memset(of.R_ref, 0, sizeof of.R_ref);
        (void)memset(of.Omega_ref, 0, sizeof of.Omega_ref);
        (void)memset(of.dOmega_ref, 0, sizeof of.dOmega_ref);
    }
    for (int i = 0; i < AHEAD_TIMES; ++i) {
        of.t_ahead[i] = absent;
        store((Vector){absent, absent, absent}, of.turn_ahead[i]);
        store((Vector){absent, absent, absent}, of.Omega_ahead[i]);
    }
    return of;
}

/* (13): the torque on wheel i that brings its momentum to rest, as far as the rods answer it, or the body has as much of
 * the opposite. */
static double to_rest(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u, int i)
{
    const double h_w = u->h_w[i], of_body = dot(law->axes[i], apply(law->J, vector(u->omega_B)));
    const double both = h_w * of_body < 0.0 ? smaller(fabs(h_w), fabs(of_body)) : 0.0;
    const double by_rods = law->rods_dipole * RODS_FIELD * RODS_SHARE, time = REST_SAMPLES * law->p.command_period;
    const double most = smaller(larger(by_rods, both / time), law->p.wheel_torque_max[i]);
    return clip(-h_w / time, -most, most);
}

static void give(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u,
                 const bool failed[WHEELS_MAX], const ControllerPlannedOutputs *of, int32_t few,
                 ControllerPlannedWheelsOutputs *y)
{
    (void)memset(y, 0, sizeof *y);
    Vector tau = vector(of->tau_cmd_B);
    for (int i = 0; i < law->p.wheels; ++i) {
        if (i != few - 1) {
            y->wheel_torque_ff[i] = failed[i] ? 0.0 : to_rest(law, u, i);
            tau = subtract(tau, scale(y->wheel_torque_ff[i], law->axes[i]));
        }
    }
    store(tau, y->tau_cmd_B);
    store(vector(of->dipole_ff), y->dipole_ff);
    if (few <= WHEELS_MAX) {
        y->wheel_torque_ff[few - 1] = of->wheel_torque_ff;
    }
    y->attitude_error = of->attitude_error;
    store(vector(of->rate_error_B), y->rate_error_B);
    store_matrix(matrix(of->R_d), y->R_d);
    store(vector(of->Omega_d), y->Omega_d);
    store(vector(of->dOmega_d), y->dOmega_d);
    y->phase = of->phase;
    y->reduced = true;
    store(vector(of->disturbance_B), y->disturbance_B);
    store(vector(of->rod_gains_estimate), y->rod_gains_estimate);
    y->rod_failed = of->rod_failed;
    y->failed_rod = of->failed_rod;
}

void controller_planned_wheels_prepare_few(ControllerPlannedWheelsLaw *law, int32_t few)
{
    const ControllerPlannedParameters p = controller_planned_wheels_few_parameters(&law->p, few);
    controller_planned_prepare(&p, &law->planned);
    law->few = few;
}

/* Prepares the plan, with the momentum of the wheels that are not in it. */
static void know_others(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u, int32_t few)
{
    Vector beside = {0.0, 0.0, 0.0};
    if (law->few != few) {
        controller_planned_wheels_prepare_few(law, few);
    }
    for (int i = 0; i < law->p.wheels; ++i) {
        beside = i == few - 1 ? beside : add(beside, scale(u->h_w[i], law->axes[i]));
    }
    law->planned.beside_B = beside;
}

bool controller_planned_wheels_step_few(ControllerPlannedWheelsLaw *law, int32_t few, bool first, double h,
                                        const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsState *x,
                                        ControllerPlannedWheelsOutputs *y, Fault *f)
{
    ControllerPlannedInputs now = controller_planned_wheels_seen(u, x, few);
    ControllerPlannedOutputs given;
    know_others(law, u, few);
    const bool begins = first || x->few != few;
    x->few = few;
    if (first) {
        if (!controller_planned_start(&law->planned, &now, &x->planned, f)) {
            return false;
        }
        given = x->planned.held;
    } else {
        if (begins) { /* as after an attitude that was lost, at this time */
            ControllerPlannedInputs none = now;
            (void)memset(none.R_NB, 0, sizeof none.R_NB);
            if (!controller_planned_start(&law->planned, &none, &x->planned, f)) {
                return false;
            }
            x->planned.t = x->t - h;
        }
        if (!controller_planned_step(&law->planned, &x->planned, &now, h, &given, f)) {
            return false;
        }
    }
    give(law, u, x->failed, &given, few, y);
    x->phase = given.phase;
    return true;
}

bool controller_planned_wheels_outputs_few(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x,
                                           const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsOutputs *y,
                                           Fault *f)
{
    const ControllerPlannedInputs now = controller_planned_wheels_seen(u, x, x->few);
    ControllerPlannedOutputs given;
    know_others(law, u, x->few);
    if (!controller_planned_outputs(&law->planned, &x->planned, &now, &given, f)) {
        return false;
    }
    give(law, u, x->failed, &given, x->few, y);
    return true;
}
