/* The commands, and the steps. Tests: tests/controller/planned/wheels/. Equations: docs/how/planned-wheels.md. */
#include "controller_planned_wheels.h"

#include <string.h>

#include "controller_planned_wheels_guard.h"
#include "sample.h"

static const double ACROSS = 2.0 / 3.0; /* of 1 - b b', the mean over all directions of the field */
static const double ACROSS_LEAST = 0.03;
static const double ACROSS_TIME = 6000.0, ACROSS_FIRST = 600.0; /* s, of its mean along the orbit */

/* (3), in phase 4: the torque that brings the rate error to rest soonest, beside the gyroscopic one where the wheels
 * can bear that, too. */
static Vector stopping(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x, const Sample *s,
                       Vector gyroscopic, Vector by_wheels)
{
    const Vector excess = apply(law->J, subtract(s->rate, controller_planned_wheels_approach(law, s, x)));
    const double size = norm(excess), L = 2.0 * law->p.command_period;
    const bool bears = norm(add(gyroscopic, by_wheels)) < 0.5 * s->most;
    double most = s->most;
    if (size > 0.0) {
        const double ball = bears ? norm(add(gyroscopic, by_wheels)) : 0.0;
        most = law->p.torque_share * zonotope_reach(&s->torque, ball, scale(1.0 / size, excess));
    }
    const Vector tau = scale(size > 0.0 ? -smaller(1.0 / L, most / size) : 0.0, excess);
    return bears ? add(tau, gyroscopic) : subtract(tau, by_wheels);
}

/* (9): the torque that answers the errors. */
static Vector feedback(const ControllerPlannedWheelsLaw *law, const Errors *e)
{
    const double k = law->p.bandwidth;
    return apply(law->J, scale(4.0 * k, add(scale(k, e->zeta), e->omega)));
}

/* (12): the mean of 1 - b b' follows the field along the orbit. */
static void follow_field(const ControllerPlannedWheelsInputs *u, Matrix Q, double h, ControllerPlannedWheelsState *x)
{
    const Matrix R = matrix(u->R_NB);
    const Vector b = vector(u->b_B);
    const double B = norm(b), share = smaller(1.0, h / smaller(ACROSS_TIME, ACROSS_FIRST + x->t));
    if (B >= WHEELS_FIELD_MIN && !is_zero_matrix(R)) {
        const Matrix turned = hat(apply(R, scale(1.0 / B, b)));
        x->across = add_scaled(add_scaled(x->across, -share, x->across), -share, multiply(turned, turned));
        const Vector seen = apply(Q, scale(1.0 / B, b));
        const Matrix lies = {scale(seen.x, seen), scale(seen.y, seen), scale(seen.z, seen)};
        x->along = add_scaled(add_scaled(x->along, -share, x->along), share, lies);
    }
}

/* (12): where little of the momentum along a direction can be taken away, more of it counts, in body axes. */
static Vector weighted(const ControllerPlannedWheelsState *x, Matrix R, Vector H)
{
    const Matrix mean = add_scaled(x->across, ACROSS_LEAST, identity);
    return apply_transposed(R, scale(ACROSS + ACROSS_LEAST, solve(mean, apply(R, H))));
}

/* The outputs at a sample. */
static void command(const ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x, const Sample *s,
                    const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsOutputs *y)
{
    const ControllerPlannedWheelsParameters *p = &law->p;
    const Vector Omega = vector(u->omega_B), b = vector(u->b_B), by_wheels = cross(Omega, s->h);
    const Vector by_body = cross(Omega, apply(law->J, Omega));
    const bool sheds = x->phase == WHEELS_SHEDDING, aimed = x->aim.whole < INFINITY;
    const double time = x->phase == WHEELS_HOLD ? p->unloading_time : UNLOADING_SOONER * p->unloading_time;
    const Matrix R = matrix(u->R_NB);
    const Vector H = is_zero_matrix(R) ? s->H : weighted(x, R, s->H);
    Vector dipole = unloading(law->rods_inverse, p->dipole_max, p->rod_limits, time, H, b);
    if (sheds && !is_zero_matrix(R)) {
        const Vector along = apply_transposed(R, aimed ? x->aim.course.lambda : x->shedding);
        dipole = shedding_dipole(law->rods, p->dipole_max, p->rod_limits, along, b);
    }
    dipole = controller_planned_wheels_by_gains(law, x->rod_gains, dipole);
    const Vector gains = x->rod_gains, given = {gains.x * dipole.x, gains.y * dipole.y, gains.z * dipole.z};
    const Vector by_rods = cross(apply_transposed(law->rods, given), b);
    const Wanted plan = controller_planned_wheels_plan_at(x, &s->target, p->command_period);
    Vector tau;
    if (sheds) {
        const Vector more = aimed ? subtract(x->aim.course.knots[0], s->h) : (Vector){0.0, 0.0, 0.0};
        const double size = norm(more), rate = 1.0 / p->command_period;
        tau = subtract(by_rods, add(by_wheels, scale(size > 0.0 ? smaller(rate, s->most / size) : 0.0, more)));
    } else if (x->phase == WHEELS_DAMPING || !s->target.attitude) {
        tau = stopping(law, x, s, by_body, by_wheels);
    } else { /* (9) */
        const Errors e = controller_planned_wheels_errors_of(&plan, matrix(u->R_NB), Omega);
        tau = add(apply(law->J, e.dOmega_d_B), by_body);
        tau = subtract(tau, add(feedback(law, &e), x->disturbance_B));
    }
    store(tau, y->tau_cmd_B);
    store(dipole, y->dipole_ff);
    controller_planned_wheels_share(law, s, u->h_w, subtract(add(tau, by_wheels), by_rods), y->wheel_torque_ff);
    y->attitude_error = s->angle;
    store(s->rate, y->rate_error_B);
    store_matrix(plan.R, y->R_d);
    store(plan.Omega, y->Omega_d);
    store(plan.dOmega, y->dOmega_d);
    y->phase = x->phase;
    y->reduced = false;
    store(x->disturbance_B, y->disturbance_B);
    controller_planned_wheels_report_rods(x->rod_gains, y);
}

/*@ requires \separated(x, y, f);
    CONTROLLER_PLANNED_WHEELS_FINITE */
bool controller_planned_wheels_outputs(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsState *x,
                                       const ControllerPlannedWheelsInputs *u, ControllerPlannedWheelsOutputs *y,
                                       Fault *f)
{
    Sample s;
    if (!controller_planned_wheels_take_sample(law, x->failed, u, &s, f)) {
        return false;
    }
    if (x->few > 0) {
        return controller_planned_wheels_outputs_few(law, x, u, y, f) && controller_planned_wheels_guard(y, f);
    }
    command(law, x, &s, u, y);
    return controller_planned_wheels_guard(y, f);
}

/* The sample of u, which ends the step h, and its outputs. */
static bool advance(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u, bool first, double h,
                    ControllerPlannedWheelsState *x, ControllerPlannedWheelsOutputs *y, Fault *f)
{
    Sample s;
    if (!controller_planned_wheels_take_sample(law, u->wheel_failed, u, &s, f)) {
        return false;
    }
    x->t += h;
    follow_field(u, s.Q, h, x);
    for (int i = 0; i < WHEELS_MAX; ++i) {
        x->failed[i] = u->wheel_failed[i];
    }
    const int32_t few = controller_planned_wheels_few(law, &s, x);
    if (few > 0) {
        x->shown = 0.0;
        return controller_planned_wheels_step_few(law, few, first, h, u, x, y, f);
    }
    controller_planned_wheels_decide(law, &s, u, first || x->few > 0, x);
    x->few = 0;
    if (first && !controller_planned_wheels_start_rods(law, u, x, f)) {
        return false;
    }
    controller_planned_wheels_watch_rods(law, &s, h, u, x);
    command(law, x, &s, u, y);
    return true;
}

bool controller_planned_wheels_start(ControllerPlannedWheelsLaw *law, const ControllerPlannedWheelsInputs *u,
                                     ControllerPlannedWheelsState *x, Fault *f)
{
    ControllerPlannedWheelsOutputs y;
    (void)memset(x, 0, sizeof *x);
    x->axis = (Vector){1.0, 0.0, 0.0};
    x->rod_gains = (Vector){1.0, 1.0, 1.0};
    x->across = add_scaled(x->across, ACROSS, identity);
    x->along = add_scaled(x->along, 1.0 - ACROSS, identity);
    x->turn = (SlewTurn){0.0, 1.0, 1.0};
    return advance(law, u, true, 0.0, x, &y, f);
}

/*@ requires \separated(x, y, f);
    CONTROLLER_PLANNED_WHEELS_FINITE */
bool controller_planned_wheels_step(ControllerPlannedWheelsLaw *law, ControllerPlannedWheelsState *x,
                                    const ControllerPlannedWheelsInputs *u, double h, ControllerPlannedWheelsOutputs *y,
                                    Fault *f)
{
    return advance(law, u, false, h, x, y, f) && controller_planned_wheels_guard(y, f);
}
