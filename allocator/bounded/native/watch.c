/* Wheels of a set that do not give what is commanded. Tests: tests/native/test_allocator_wheels.py. */
#include "actuators.h"

#if ALLOCATOR_BOUNDED_WHEELS > 1

static const double FORGOTTEN = 300.0; /* s, in which what a wheel gave is forgotten */
static const double TRUST_TORQUE = 0.02,
                    TRUST_TIME = 100.0; /* of its limit, s: commands below say nothing of a wheel */
static const double RETRY = 3000.0;     /* s, after which a wheel that failed is tried again */

double allocator_bounded_wheel_gain(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                    const AllocatorBoundedInputs *u, int i)
{
    if (allocator_bounded_has_wheel_gains(u)) {
        return u->wheel_gains[i];
    }
    return law->p.find_failures && x->wheels[i].failed_for > 0.0 ? 0.0 : 1.0;
}

void allocator_bounded_watch(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h,
                             AllocatorBoundedState *x)
{
    const double kept = 1.0 / (1.0 + h / FORGOTTEN);
    for (int i = 0; i < law->p.wheels; ++i) {
        WatchedWheel *wheel = &x->wheels[i];
        if (wheel->failed_for > 0.0) {
            const double longer = wheel->failed_for + h;
            *wheel = (WatchedWheel){.failed_for = longer > RETRY ? 0.0 : longer};
            continue;
        }
        const double torque = TRUST_TORQUE * law->p.wheel_torque_max[i], trust = torque * torque * TRUST_TIME;
        wheel->given = kept * wheel->given + wheel->command * (u->h_w[i] - wheel->h_w);
        wheel->asked = kept * wheel->asked + wheel->command * wheel->command * h;
        wheel->failed_for = wheel->given + trust < 0.5 * (wheel->asked + trust) ? h : 0.0;
    }
}

void allocator_bounded_keep(const AllocatorBoundedInputs *u, const AllocatorBoundedOutputs *y, AllocatorBoundedState *x)
{
    for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
        x->wheels[i].h_w = u->h_w[i];
        x->wheels[i].command = y->wheel_torque_cmd[i];
    }
}

#endif
