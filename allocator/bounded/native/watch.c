/* Wheels of a set that do not give what is commanded.
 * Requirement: AB-3. Tests: tests/native/test_allocator_wheels.py. */
#include "actuators.h"

#if ALLOCATOR_BOUNDED_WHEELS > 1

static const double FORGOTTEN = 300.0;   /* s, in which what a wheel gave is forgotten */
static const double TRUST_TORQUE = 0.02; /* of its limit: commands below, for so long, say nothing of a wheel */
static const double TRUST_TIME = 100.0;  /* s */
static const double RETRY = 3000.0;      /* s, after which a wheel that failed is tried again */

bool allocator_bounded_wheel_failed(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i)
{
    return law->p.find_failures && x->failed_for[i] > 0.0;
}

double allocator_bounded_wheel_gain(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                    const AllocatorBoundedInputs *u, int i)
{
    if (allocator_bounded_has_wheel_gains(u)) {
        return u->wheel_gains[i];
    }
    return allocator_bounded_wheel_failed(law, x, i) ? 0.0 : 1.0;
}

void allocator_bounded_watch(const AllocatorBoundedLaw *law, const AllocatorBoundedInputs *u, double h,
                             AllocatorBoundedState *x)
{
    const double kept = 1.0 / (1.0 + h / FORGOTTEN);
    for (int i = 0; i < law->p.wheels; ++i) {
        if (x->failed_for[i] > 0.0) {
            const double longer = x->failed_for[i] + h;
            x->given[i] = 0.0;
            x->asked[i] = 0.0;
            x->failed_for[i] = longer > RETRY ? 0.0 : longer;
            continue;
        }
        const double torque = TRUST_TORQUE * law->p.wheel_torque_max[i], trust = torque * torque * TRUST_TIME;
        x->given[i] = kept * x->given[i] + x->command[i] * (u->h_w[i] - x->h_w[i]);
        x->asked[i] = kept * x->asked[i] + x->command[i] * x->command[i] * h;
        x->failed_for[i] = x->given[i] + trust < 0.5 * (x->asked[i] + trust) ? h : 0.0;
    }
}

void allocator_bounded_keep(const AllocatorBoundedInputs *u, const AllocatorBoundedOutputs *y, AllocatorBoundedState *x)
{
    for (int i = 0; i < ALLOCATOR_BOUNDED_WHEELS; ++i) {
        x->h_w[i] = u->h_w[i];
        x->command[i] = y->wheel_torque_cmd[i];
    }
}

#endif
