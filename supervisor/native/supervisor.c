/* Tests: tests/native/test_flavours.py. */
#include "supervisor.h"

#include "supervisor_guard.h"
#include "ahead.h"
#include "modes.h"

#include <string.h>

static const double HALF_PI = 1.57079632679489661923, TWO_PI = 6.28318530717958647692; /* rad */
static const double HEIGHT_MIN = -12e3, HEIGHT_MAX = 1e6;                              /* m */
enum { YEAR_MIN = 1900, YEAR_MAX = 2100 }; /* for which sidereal time is a cubic */

bool supervisor_check(const SupervisorParameters *p, Fault *f)
{
    const Named positive[] = {
        {"slew_rate_max", p->slew_rate_max}, {"slew_torque_max", p->slew_torque_max},
        {"rate_acquire", p->rate_acquire},   {"rate_lost", p->rate_lost},
        {"settled_angle", p->settled_angle}, {"settled_rate", p->settled_rate},
        {"angle_lost", p->angle_lost},       {"gravitational_parameter", p->gravitational_parameter},
        {"safe_time", p->safe_time},         {"bound_lost", p->bound_lost},
    };
    const Named not_negative[] = {{"rate_time", p->rate_time},
                                  {"settled_time", p->settled_time},
                                  {"angle_time", p->angle_time},
                                  {"attitude_time", p->attitude_time},
                                  {"ahead_horizon", p->ahead_horizon}};
    const Named finite = {"target_yaw_angle", p->target_yaw_angle};
    Epoch epoch = {0, 0, 0, 0};
    if (!all_positive(positive, COUNT(positive), f) || !all_not_negative(not_negative, COUNT(not_negative), f) ||
        !all_finite(&finite, 1, f)) {
        return false;
    }
    if (p->first_mode < SUPERVISOR_FIRST_MODE_NADIR || p->first_mode > SUPERVISOR_FIRST_MODE_SUN) {
        return fault(f, "first_mode", p->first_mode, "1 (nadir), 2 (inertial), 3 (target) or 4 (sun)");
    }
    if (p->target_yaw < SUPERVISOR_TARGET_YAW_STEERED || p->target_yaw > SUPERVISOR_TARGET_YAW_FREE) {
        return fault(f, "target_yaw", p->target_yaw, "1 (steered) or 2 (free)");
    }
    if (p->safe_pointing < SUPERVISOR_SAFE_POINTING_NONE || p->safe_pointing > SUPERVISOR_SAFE_POINTING_SUN) {
        return fault(f, "safe_pointing", p->safe_pointing, "1 (none), 2 (field) or 3 (sun)");
    }
    if (!(p->rate_acquire <= p->rate_lost)) {
        return fault(f, "rate_lost", p->rate_lost, "at least rate_acquire");
    }
    if (!is_unit_vector(vector(p->sun_axis_B), "sun_axis_B", f) ||
        !is_unit_vector(vector(p->safe_axis_B), "safe_axis_B", f) || !is_inertia(matrix(p->J_B), "J_B", f) ||
        !is_epoch(p->epoch, &epoch, f)) {
        return false;
    }
    return (epoch.year >= YEAR_MIN && epoch.year <= YEAR_MAX) ||
           fault(f, "epoch", epoch.year, "a year from 1900 to 2100");
}

void supervisor_prepare(const SupervisorParameters *p, SupervisorLaw *law)
{
    Epoch epoch = {0, 0, 0, 0};
    law->p = *p;
    (void)epoch_read(p->epoch, &epoch);
    law->sidereal_angle_0 = epoch_sidereal_angle(&epoch);
}

static bool inputs_fit(const SupervisorInputs *u, Fault *f)
{
    const Matrix R = matrix(u->R_NB), goal = matrix(u->R_goal);
    const NamedVector vectors[] = {{"R_NB", R.a},           {"R_NB", R.b},
                                   {"R_NB", R.c},           {"omega_B", vector(u->omega_B)},
                                   {"r_N", vector(u->r_N)}, {"v_N", vector(u->v_N)},
                                   {"R_goal", goal.a},      {"R_goal", goal.b},
                                   {"R_goal", goal.c},      {"sun_N", vector(u->sun_N)},
                                   {"b_B", vector(u->b_B)}, {"sun_B", vector(u->sun_B)}};
    const Named numbers[] = {{"target_latitude", u->target_latitude},
                             {"target_longitude", u->target_longitude},
                             {"target_height", u->target_height},
                             {"sunlight", u->sunlight},
                             {"attitude_bound", u->attitude_bound}};
    if (!all_finite_vectors(vectors, COUNT(vectors), f) || !all_finite(numbers, COUNT(numbers), f)) {
        return false;
    }
    if (supervisor_has_target_latitude(u) && !(fabs(u->target_latitude) <= HALF_PI)) {
        return fault(f, "target_latitude", u->target_latitude, "at least -pi/2 and at most pi/2");
    }
    if (supervisor_has_target_longitude(u) && !(fabs(u->target_longitude) <= TWO_PI)) {
        return fault(f, "target_longitude", u->target_longitude, "at least -2 pi and at most 2 pi");
    }
    if (supervisor_has_target_height(u) && !(u->target_height >= HEIGHT_MIN && u->target_height <= HEIGHT_MAX)) {
        return fault(f, "target_height", u->target_height, "at least -12e3 and at most 1e6");
    }
    if (u->command == SUPERVISOR_ACQUIRE || u->command == SUPERVISOR_SLEW || u->command > SUPERVISOR_SUN) {
        return fault(f, "command", u->command, "0 (none), 1 (safe), 3 (nadir), 4 (inertial), 6 (target) or 7 (sun)");
    }
    return !u->attitude_valid || is_zero_matrix(R) || is_attitude(R, f);
}

static bool outputs_of(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                       SupervisorOutputs *y, Fault *f)
{
    Reference now = SUPERVISOR_NO_REFERENCE;
    if (!inputs_fit(u, f) || !supervisor_reference_now(law, x, u, &now, f)) {
        return false;
    }
    store_matrix(now.R_d, y->R_ref);
    store(now.Omega_d, y->Omega_ref);
    store(now.dOmega_d, y->dOmega_ref);
    for (int k = 0; k < SUPERVISOR_AHEAD; ++k) {
        y->t_ahead[k] = x->ahead.next > 0.0 ? x->ahead.t[k] - x->t : 0.0;
        store(x->ahead.turn[k], y->turn_ahead[k]);
        store(x->ahead.Omega[k], y->Omega_ahead[k]);
    }
    y->mode = x->mode;
    y->destination = x->destination;
    y->safe_reason = x->safe_reason;
    y->slew_remaining = x->mode == SUPERVISOR_SLEW ? larger(x->slew_start + x->slew.duration - x->t, 0.0) : 0.0;
    y->target_elevation = -HALF_PI;
    if (supervisor_has_target_latitude(u) && supervisor_has_target_longitude(u) && supervisor_has_target_height(u)) {
        const Vector point = supervisor_point_on_earth(u->target_latitude, u->target_longitude, u->target_height);
        y->target_elevation = supervisor_elevation(point, u->target_latitude, u->target_longitude,
                                                   supervisor_angle_of_earth(law, x), vector(u->r_N));
    }
    return true;
}

/*@ requires \separated(x, y, f);
    SUPERVISOR_FINITE */
bool supervisor_outputs(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                        SupervisorOutputs *y, Fault *f)
{
    return outputs_of(law, x, u, y, f) && supervisor_guard(y, f);
}

bool supervisor_start(const SupervisorLaw *law, const SupervisorInputs *u, SupervisorState *x, Fault *f)
{
    memset(x, 0, sizeof *x);
    x->mode = x->destination = SUPERVISOR_SAFE;
    x->safe_reason = SUPERVISOR_SINCE_START;
    return inputs_fit(u, f) && supervisor_advance(law, u, 0.0, x, f) && supervisor_look_ahead(law, u, x, f);
}

/* The state after the step h from x. */
static bool moved(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u, double h,
                  SupervisorState *next, Fault *f)
{
    if (!inputs_fit(u, f) || !supervisor_advance(law, u, h, next, f)) {
        return false;
    }
    const bool other =
        next->mode != x->mode || next->destination != x->destination || next->slew_start != x->slew_start;
    /* to a millionth of the step, since t is a sum of steps */
    return (!other && !(next->t >= next->ahead.next - 1e-6 * h)) || supervisor_look_ahead(law, u, next, f);
}

/*@ requires \separated(x, y, f);
    SUPERVISOR_FINITE */
bool supervisor_step(const SupervisorLaw *law, SupervisorState *x, const SupervisorInputs *u, double h,
                     SupervisorOutputs *y, Fault *f)
{
    SupervisorState next = *x;
    if (!moved(law, x, u, h, &next, f) || !supervisor_outputs(law, &next, u, y, f)) {
        return false;
    }
    *x = next;
    return true;
}
