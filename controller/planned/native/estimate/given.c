/* What rods and wheel gave over a sample: docs/how/planned-estimates.md, Failures. Tests: test_failures.py. */
#include "../state.h"

#include <string.h>

/* dl/dt, N m, that the wheel gives of a motor's torque by what is known of its friction. */
static double by_command(const ControllerPlannedState *x, double told, double dt)
{
    return told - controller_planned_friction_torque(&x->friction, x->l_own, told, dt);
}

/* Whether h_w is frozen: while a wheel is commanded, it repeats to the bit. One that is stuck does not where h_w has
 * noise. From then on the momentum is the last one that changed, and what the wheel gave since. */
static void watch_momentum(ControllerPlannedState *x, const ControllerPlannedInputs *u, double dt)
{
    const bool noisy = !x->friction.stuck && controller_planned_momentum_noisy(&x->friction, dt),
               was = x->momentum.frozen;
    controller_planned_watch_momentum(dt, u->h_w, by_command(x, u->u_applied[3], dt), noisy, &x->momentum);
    if (x->momentum.frozen && !was) {
        x->l_own = x->momentum.l - dt * by_command(x, u->u_applied[3], dt); /* of the last sample: this one follows */
    }
}

void controller_planned_given(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                              const ControllerPlannedInputs *u, double dt, double given[CONTROLS])
{
    const ControllerPlannedParameters *p = &law->p;
    if (p->find_failures && controller_planned_has_h_w(u) && controller_planned_has_u_applied(u)) {
        watch_momentum(x, u, dt);
    }
    memcpy(given, x->u, sizeof x->u);
    if (controller_planned_has_u_applied(u)) {
        double limits[3];
        store(controller_planned_rod_dipoles(p), limits);
        for (int i = 0; i < 3; ++i) {
            given[i] = u->u_applied[i] / limits[i];
        }
        given[3] = u->u_applied[3] / p->wheel_torque_max;
    }
    if (controller_planned_has_h_w(u)) {
        const double told = controller_planned_has_u_applied(u) ? u->u_applied[3] : x->held.wheel_torque_ff;
        const double rate = x->momentum.blind
                                ? by_command(x, told, dt)
                                : controller_planned_wheel_rate(dt, told, x->measured.l, u->h_w, &x->friction);
        given[3] = rate / p->wheel_torque_max;
    }
}
