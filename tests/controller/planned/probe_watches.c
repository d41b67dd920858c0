/* The planned controller's watches of rods, sensors and wheel over n samples, for tests: flat arrays in, flat arrays
 * out. */
#include "decide/guard.h"
#include "probe_flat.h"

/* Innovations of the rate (n,3) against effects of `effect` rad/s along each axis, of variance 1; the satellite turns
 * at body[i]. Where begun[i], the filter begins anew before the sample. */
PROBE void probe_watch_rods(double dt, double T, double pause, double effect, int n, const double *body,
                            const double *innovations, const unsigned char *begun, unsigned char *suspected)
{
    RodsWatch watch;
    memset(&watch, 0, sizeof watch);
    watch.pause = pause;
    watch.effect[0].x = watch.effect[1].y = watch.effect[2].z = effect;
    for (int i = 0; i < n; ++i) {
        watch.rate = body[i];
        if (begun[i]) {
            controller_planned_pause_watch(T, &watch);
        }
        suspected[i] = controller_planned_watch_rods(dt, T, vector(innovations + 3 * i), 1.0, &watch);
    }
}

/* Attitudes (n,9) and rates (n,3): whether each is frozen, and what stands in for it. */
PROBE void probe_watch_attitude(double dt, double T, double noise, int n, const double *R, const double *Omega,
                                unsigned char *is_frozen, double *turned_R)
{
    SensorsWatch watch;
    memset(&watch, 0, sizeof watch);
    for (int i = 0; i < n; ++i) {
        const Vector before = vector(Omega + 3 * (i > 0 ? i - 1 : 0));
        controller_planned_watch_attitude(dt, T, noise, nine(R + 9 * i), before, vector(Omega + 3 * i), &watch);
        is_frozen[i] = watch.attitude_frozen;
        nine_of(watch.turned_R, turned_R + 9 * i);
    }
}

/* Measured and expected fields (n,3): whether each has failed. */
PROBE void probe_watch_field(double dt, double T, double tolerance, int n, const double *b, const double *model,
                             unsigned char *failed)
{
    SensorsWatch watch;
    memset(&watch, 0, sizeof watch);
    for (int i = 0; i < n; ++i) {
        controller_planned_watch_field(dt, T, tolerance, vector(b + 3 * i), vector(model + 3 * i), &watch);
        failed[i] = watch.field_failed;
    }
}

/* Measured momenta while the wheel gives given[i]: whether each is frozen, what stands in for it, and whether it shows
 * nothing of its change. */
PROBE void probe_watch_momentum(double dt, double limit, int n, const double *h_w, const double *given,
                                unsigned char *is_frozen, unsigned char *blind, double *l)
{
    MomentumWatch watch;
    memset(&watch, 0, sizeof watch);
    for (int i = 0; i < n; ++i) {
        watch_momentum(dt, h_w[i], given[i], limit, h_w[i] != 0.0 ? 0.5 : INFINITY, false, &watch);
        is_frozen[i] = watch.frozen;
        blind[i] = watch.blind;
        l[i] = watch.l;
    }
}

/* Torques that are asked of a wheel, and its momentum before and after each sample: whether it has failed, or is
 * stuck. */
PROBE void probe_watch_wheel(const ControllerPlannedParameters *p, double dt, double T, int n, const double *torque,
                             const double *l, const double *l_next, unsigned char *failed, unsigned char *stuck)
{
    Friction friction;
    controller_planned_friction_start(p, T, &friction);
    for (int i = 0; i < n; ++i) {
        controller_planned_friction_learn(dt, torque[i], l[i], l_next[i], &friction);
        controller_planned_wheel_changes(&friction);
        failed[i] = controller_planned_wheel_failed(&friction);
        stuck[i] = friction.stuck;
    }
}

/* The same torques and momenta: what is known of the wheel's friction, Coulomb's and viscous, (n,2). */
PROBE void probe_friction(const ControllerPlannedParameters *p, double dt, double T, int n, const double *torque,
                          const double *l, const double *l_next, double *known)
{
    Friction friction;
    controller_planned_friction_start(p, T, &friction);
    for (int i = 0; i < n; ++i) {
        controller_planned_friction_learn(dt, torque[i], l[i], l_next[i], &friction);
        memcpy(known + 2 * i, friction.p, sizeof friction.p);
    }
}

/* The same: how fast the momentum of a wheel without friction is taken to change. */
PROBE void probe_wheel_rate(const ControllerPlannedParameters *p, double dt, double T, int n, const double *torque,
                            const double *l, const double *l_next, double *rate)
{
    Friction friction;
    controller_planned_friction_start(p, T, &friction);
    for (int i = 0; i < n; ++i) {
        rate[i] = controller_planned_wheel_rate(dt, torque[i], l[i], l_next[i], &friction);
    }
}

/* Commands, dipole_ff, wheel_torque_ff and tau_cmd_B, through the guard: `refused` is 0, or the first letter of the
 * output that is. */
PROBE void probe_guard(const double rods[3], double torque_max, double commands[7], unsigned char *refused)
{
    Fault f = {"", "", NULL, 0.0};
    ControllerPlannedParameters p = {.dipole_max = 1.0, .rod_limits = {rods[0], rods[1], rods[2]}};
    p.wheel_torque_max = torque_max;
    ControllerPlannedOutputs y;
    memset(&y, 0, sizeof y);
    memcpy(y.dipole_ff, commands, sizeof y.dipole_ff);
    y.wheel_torque_ff = commands[3];
    memcpy(y.tau_cmd_B, commands + 4, sizeof y.tau_cmd_B);
    *refused = controller_planned_give(&p, &y, &f) ? 0 : (unsigned char)f.name[0];
    memcpy(commands, y.dipole_ff, sizeof y.dipole_ff);
    commands[3] = y.wheel_torque_ff;
    memcpy(commands + 4, y.tau_cmd_B, sizeof y.tau_cmd_B);
}
