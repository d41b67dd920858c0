/* What rods and wheel gave over a sample: docs/how/planned-estimates.md, Failures. Tests: test_failures.py. */
#include "../state.h"

#include <string.h>

/* Share of the slip's square that is noise where the momentum has noise. Zero may be what is counted of a wheel that
 * stands, and repeat. */
static const double MOSTLY = 0.5;

/* dl/dt, N m, that the wheel gives of a motor's torque by what is known of its friction. */
static double by_command(const ControllerPlannedState *x, double told, double dt)
{
    return told - controller_planned_friction_torque(&x->friction, x->l_own, told, dt);
}

void controller_planned_watch_h_w(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                                  const ControllerPlannedInputs *u, double dt)
{
    if (!law->p.find_failures || !controller_planned_has_h_w(u) || !controller_planned_has_u_applied(u)) {
        return;
    }
    const bool was = x->momentum.frozen;
    const double given = by_command(x, u->u_applied[3], dt);
    watch_momentum(dt, u->h_w, given, law->p.wheel_momentum_max, u->h_w != 0.0 ? MOSTLY : INFINITY, false,
                   &x->momentum);
    if (x->momentum.frozen && !was) {
        x->l_own = x->momentum.l - dt * given; /* of the last sample: this one follows */
    }
}

void controller_planned_given(const ControllerPlannedLaw *law, ControllerPlannedState *x,
                              const ControllerPlannedInputs *u, double dt, double given[CONTROLS])
{
    const ControllerPlannedParameters *p = &law->p;
    controller_planned_watch_h_w(law, x, u, dt);
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
