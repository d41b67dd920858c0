/* The reference of each mode, and how one mode gives way to another. Requirement: SV-1. */
#include "modes.h"

#include <string.h>

#include "safe.h"

static const double SUNLIT = 0.5;                  /* below this sunlight the satellite is in eclipse */
static const double SUN_LOW = 0.5, SUN_HIGH = 2.0; /* lengths of what may be a unit vector */
static const Vector BORESIGHT_B = {0.0, 0.0, 1.0}; /* the body axis that looks at a target */
static const Vector STILL = {0.0, 0.0, 0.0};

double supervisor_angle_of_earth(const SupervisorLaw *law, const SupervisorState *x)
{
    return law->sidereal_angle_0 + SUPERVISOR_EARTH_RATE * x->t;
}

bool supervisor_destination(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                            Reference *to, Fault *f)
{
    const SupervisorParameters *p = &law->p;
    const Vector r = vector(u->r_N), v = vector(u->v_N), sun = vector(u->sun_N);
    const double *aim = x->aim;
    if (x->destination == SUPERVISOR_INERTIAL) {
        *to = (Reference){{vector(aim), vector(aim + 3), vector(aim + 6)}, STILL, STILL};
    } else if (x->destination == SUPERVISOR_SUN) {
        const double size = norm(sun);
        if (!(size > SUN_LOW && size < SUN_HIGH)) {
            return fault(f, "sun_N", size, "a unit vector");
        }
        *to = supervisor_free(vector(p->sun_axis_B), (Moving){scale(1.0 / size, sun), STILL, STILL}, x->kept);
    } else if (x->destination == SUPERVISOR_TARGET) {
        const Vector point = supervisor_point_on_earth(aim[0], aim[1], aim[2]), h = cross(r, v);
        const Moving z =
            supervisor_line_of_sight(point, supervisor_angle_of_earth(law, x), r, v, p->gravitational_parameter);
        *to = p->target_yaw == SUPERVISOR_TARGET_YAW_FREE
                  ? supervisor_free(BORESIGHT_B, z, x->kept)
                  : supervisor_steered(z, scale(1.0 / norm(h), h), p->target_yaw_angle);
    } else {
        return reference_lvlh(r, v, to, f);
    }
    return true;
}

bool supervisor_reference_now(const SupervisorLaw *law, const SupervisorState *x, const SupervisorInputs *u,
                              Reference *now, Fault *f)
{
    if (x->mode == SUPERVISOR_SAFE) {
        *now = (Reference){{STILL, STILL, STILL}, x->towards, STILL};
        return true;
    }
    Reference to = SUPERVISOR_NO_REFERENCE;
    if (!supervisor_destination(law, x, u, &to, f)) {
        return false;
    }
    *now = x->mode == SUPERVISOR_SLEW ? supervisor_slew_at(&x->slew, x->t - x->slew_start, &to) : to;
    return true;
}

/* The mode that is asked for: by the command, else the first one; in eclipse nothing is to be had from the Sun. */
static int32_t mode_wanted(const SupervisorParameters *p, const SupervisorInputs *u)
{
    static const int32_t first[] = {SUPERVISOR_NADIR, SUPERVISOR_INERTIAL, SUPERVISOR_TARGET, SUPERVISOR_SUN};
    const int32_t wanted = u->command > 0 ? u->command : first[p->first_mode - 1];
    return wanted == SUPERVISOR_SUN && supervisor_has_sunlight(u) && u->sunlight < SUNLIT ? SUPERVISOR_NADIR : wanted;
}

/* The target of the mode, as the state keeps it. */
static bool aim_of(int32_t wanted, const SupervisorInputs *u, double aim[9], Fault *f)
{
    static const char *const needed = "a value, since its mode is asked for (1e9: not connected)";
    memset(aim, 0, 9 * sizeof aim[0]);
    if (wanted == SUPERVISOR_INERTIAL) {
        const Matrix goal = matrix(u->R_goal);
        if (!supervisor_has_R_goal(u)) {
            return fault(f, "R_goal", largest_element(goal), needed);
        }
        memcpy(aim, u->R_goal, sizeof u->R_goal);
        return is_rotation(goal, REFERENCE_ATTITUDE_TOLERANCE, "R_goal",
                           "a rotation matrix, max |R_goal^T R_goal - I| at most 0.0001", f);
    }
    if (wanted == SUPERVISOR_TARGET) {
        const double given[] = {u->target_latitude, u->target_longitude, u->target_height};
        const bool has[] = {supervisor_has_target_latitude(u), supervisor_has_target_longitude(u),
                            supervisor_has_target_height(u)};
        static const char *const names[] = {"target_latitude", "target_longitude", "target_height"};
        for (int i = 0; i < 3; ++i) {
            if (!has[i]) {
                return fault(f, names[i], given[i], needed);
            }
        }
        memcpy(aim, given, sizeof given);
    }
    if (wanted == SUPERVISOR_SUN && !supervisor_has_sun_N(u)) {
        return fault(f, "sun_N", largest(vector(u->sun_N)), needed);
    }
    return true;
}

/* On the way to another destination: by a slew from the present reference, in acquisition at once. */
static bool turn_to(const SupervisorLaw *law, int32_t wanted, const double aim[9], const SupervisorInputs *u,
                    SupervisorState *x, Fault *f)
{
    Reference now = SUPERVISOR_NO_REFERENCE, to = now;
    if (!supervisor_reference_now(law, x, u, &now, f)) {
        return false;
    }
    x->destination = wanted;
    memcpy(x->aim, aim, sizeof x->aim);
    x->kept = now.R_d;
    if (x->mode == SUPERVISOR_ACQUIRE) {
        x->settled = 0.0;
        return true;
    }
    if (!supervisor_destination(law, x, u, &to, f)) {
        return false;
    }
    x->mode = SUPERVISOR_SLEW;
    x->slew_start = x->t;
    x->slew = supervisor_slew_begin(&now, &to, matrix(law->p.J_B), law->p.slew_rate_max, law->p.slew_torque_max);
    x->off = 0.0;
    return true;
}

/* Acquisition ends where the errors have been small for a time, and begins where they have been large. */
static bool judge(const SupervisorLaw *law, const SupervisorInputs *u, double h, SupervisorState *x, Fault *f)
{
    const SupervisorParameters *p = &law->p;
    Reference now = SUPERVISOR_NO_REFERENCE;
    if (!supervisor_reference_now(law, x, u, &now, f)) {
        return false;
    }
    const Matrix Q = multiply(transposed(now.R_d), matrix(u->R_NB));
    const double angle = principal_angle(Q);
    const double rate = norm(subtract(vector(u->omega_B), apply_transposed(Q, now.Omega_d)));
    if (x->mode == SUPERVISOR_ACQUIRE) {
        const bool settled = angle < p->settled_angle && rate < p->settled_rate;
        x->settled = settled ? x->settled + h : 0.0;
        if (settled && x->settled >= p->settled_time) {
            x->mode = x->destination;
            x->off = 0.0;
        }
        return true;
    }
    const bool off = angle > p->angle_lost;
    x->off = off ? x->off + h : 0.0;
    if (off && x->off >= p->angle_time) {
        x->mode = SUPERVISOR_ACQUIRE;
        x->settled = 0.0;
    }
    return true;
}

bool supervisor_advance(const SupervisorLaw *law, const SupervisorInputs *u, double h, SupervisorState *x, Fault *f)
{
    const SupervisorParameters *p = &law->p;
    const bool bounded = !supervisor_has_attitude_bound(u) || u->attitude_bound <= p->bound_lost;
    const bool known = u->attitude_valid && bounded && !is_zero_matrix(matrix(u->R_NB));
    const double rate = norm(vector(u->omega_B));
    const bool calm = rate<p->rate_acquire, fast = rate> p->rate_lost;
    const int32_t wanted = mode_wanted(p, u);
    double aim[9];
    Reference to = SUPERVISOR_NO_REFERENCE;
    x->t += h;
    x->calm = calm ? x->calm + h : 0.0;
    x->fast = fast ? x->fast + h : 0.0;
    x->blind = known ? 0.0 : x->blind + h;
    const bool spins = fast && x->fast >= p->rate_time;
    const bool lost = (!known && x->blind >= p->attitude_time) || spins;
    if (wanted == SUPERVISOR_SAFE || (x->mode != SUPERVISOR_SAFE && lost)) {
        const SupervisorState was = *x;
        memset(x, 0, sizeof *x);
        x->t = was.t;
        x->calm = was.calm;
        x->fast = was.fast;
        x->blind = was.blind;
        x->mode = x->destination = SUPERVISOR_SAFE;
        x->safe_reason = wanted == SUPERVISOR_SAFE ? SUPERVISOR_BY_COMMAND
                         : spins                   ? SUPERVISOR_TOO_FAST
                                                   : SUPERVISOR_NO_ATTITUDE;
        if (was.mode == SUPERVISOR_SAFE) {
            x->field_direction = was.field_direction;
            x->field_rate = was.field_rate;
            x->towards = was.towards;
        }
        return supervisor_point_safe(law, u, h, x, f);
    }
    if (!aim_of(wanted, u, aim, f)) {
        return false;
    }
    if (x->mode == SUPERVISOR_SAFE) {
        if (!(known && calm && x->calm >= p->rate_time)) {
            return supervisor_point_safe(law, u, h, x, f);
        }
        x->field_direction = x->field_rate = x->towards = STILL;
        x->mode = SUPERVISOR_ACQUIRE;
        x->safe_reason = SUPERVISOR_NOT_SAFE;
        x->destination = wanted;
        memcpy(x->aim, aim, sizeof aim);
        x->kept = matrix(u->R_NB);
        x->settled = x->off = 0.0;
    } else if ((wanted != x->destination || memcmp(aim, x->aim, sizeof aim) != 0) &&
               !turn_to(law, wanted, aim, u, x, f)) {
        return false;
    }
    if (x->mode == SUPERVISOR_SLEW && x->t >= x->slew_start + x->slew.duration) {
        x->mode = x->destination;
    }
    if (!supervisor_destination(law, x, u, &to, f)) {
        return false;
    }
    x->kept = to.R_d;
    return !known || judge(law, u, h, x, f);
}
