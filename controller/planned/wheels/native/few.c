/* One wheel that works, or none: the plan of controller_planned. docs/how/planned-wheels.md, Failures. */
#include <string.h>

#include "sample.h"

static const double NO_WHEEL = 1e-9; /* N m and N m s: of a satellite without wheel */

int32_t controller_planned_wheels_few(const ControllerPlannedWheelsLaw *law, const bool failed[WHEELS_MAX])
{
    int32_t last = WHEELS_MAX + 1, count = 0;
    for (int i = 0; i < law->p.wheels; ++i) {
        if (!failed[i]) {
            last = i + 1;
            count += 1;
        }
    }
    return count > 1 ? 0 : last;
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
static ControllerPlannedInputs seen(const ControllerPlannedWheelsInputs *u, const ControllerPlannedWheelsState *x,
                                    int32_t few)
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

static void give(const ControllerPlannedOutputs *of, int32_t few, ControllerPlannedWheelsOutputs *y)
{
    (void)memset(y, 0, sizeof *y);
    store(vector(of->tau_cmd_B), y->tau_cmd_B);
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
}

void controller_planned_wheels_prepare_few(ControllerPlannedWheelsLaw *law, int32_t few)
{
    const ControllerPlannedParameters p = controller_planned_wheels_few_parameters(&law->p, few);
    controller_planned_prepare(&p, &law->planned);
    law->few = few;
}

static void change_to(ControllerPlannedWheelsLaw *law, int32_t few)
{
    if (law->few != few) {
        controller_planned_wheels_prepare_few(law, few);
    }
}

bool controller_planned_wheels_step_few(ControllerPlannedWheelsLaw *law, int32_t few, bool first, double h,
                                        const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsState *x,
                                        ControllerPlannedWheelsOutputs *y, Fault *f)
{
    ControllerPlannedInputs now = seen(u, x, few);
    ControllerPlannedOutputs given;
    change_to(law, few);
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
    give(&given, few, y);
    x->phase = given.phase;
    return true;
}

bool controller_planned_wheels_outputs_few(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x,
                                           const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsOutputs *y,
                                           Fault *f)
{
    const ControllerPlannedInputs now = seen(u, x, x->few);
    ControllerPlannedOutputs given;
    change_to(law, x->few);
    if (!controller_planned_outputs(&law->planned, &x->planned, &now, &given, f)) {
        return false;
    }
    give(&given, x->few, y);
    return true;
}
