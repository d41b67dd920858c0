/* What is known of a wheel of a set that failed, and its trials: docs/how/allocator.md, A set of wheels.
 * Requirement: AB-3. Tests: tests/native/test_allocator_failed_wheels.py. */
#include "trial.h"

#include "vector.h"

#if ALLOCATOR_BOUNDED_WHEELS > 1

/* Of its limit, and s: the command by which it is tried, forth and back. */
static const double PROBE_TORQUE = 0.2, PROBE_TIME = 2.0;
static const double WORKS = 0.5; /* of its command: a wheel that gives more is used, by the sign with which it does */

bool allocator_bounded_wheel_failed(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i)
{
    return law->p.find_failures && x->failed_for[i] > 0.0;
}

bool allocator_bounded_wheel_reversed(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i)
{
    return law->p.find_failures && x->tried[i] < -WORKS;
}

double allocator_bounded_sign(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x, int i)
{
    return allocator_bounded_wheel_reversed(law, x, i) ? -1.0 : 1.0;
}

double allocator_bounded_wheel_momentum(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                        const AllocatorBoundedInputs *u, int i)
{
    return law->p.find_failures && x->telemetry[i].frozen ? x->telemetry[i].l : u->h_w[i];
}

double allocator_bounded_wheel_gain(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                    const AllocatorBoundedInputs *u, int i)
{
    if (allocator_bounded_has_wheel_gains(u)) {
        return u->wheel_gains[i];
    }
    return allocator_bounded_wheel_failed(law, x, i) ? 0.0 : allocator_bounded_sign(law, x, i);
}

double allocator_bounded_tried_torque(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                      const AllocatorBoundedInputs *u, int i, double preferred)
{
    const double since = x->failed_for[i] - RETRY;
    if (allocator_bounded_has_wheel_gains(u)) {
        return preferred;
    }
    if (since <= 0.0 || !law->p.find_failures) {
        return allocator_bounded_sign(law, x, i) * preferred;
    }
    const double first = allocator_bounded_wheel_momentum(law, x, u, i) > 0.5 * law->p.wheel_momentum_max[i]
                             ? -PROBE_TORQUE
                             : PROBE_TORQUE; /* a wheel that is full is slowed down first */
    return (since < 0.5 * (PROBE_TIME + law->p.command_period) ? first : -first) * law->p.wheel_torque_max[i];
}

bool allocator_bounded_is_tried(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                const AllocatorBoundedInputs *u, int i)
{
    return law->p.find_failures && x->failed_for[i] > RETRY && !allocator_bounded_has_wheel_gains(u);
}

double allocator_bounded_by_trial(const AllocatorBoundedLaw *law, const AllocatorBoundedState *x,
                                  const AllocatorBoundedInputs *u, int i)
{
    return x->failed_for[i] > RETRY ? x->tried[i] * allocator_bounded_tried_torque(law, x, u, i, 0.0) : 0.0;
}

void allocator_bounded_forget(AllocatorBoundedState *x, int i)
{
    x->given[i] = x->asked[i] = x->answered[i] = x->called[i] = x->slow_command[i] = x->slow_answer[i] = 0.0;
}

void allocator_bounded_try_again(AllocatorBoundedState *x, double forth, double h, int i)
{
    const bool ends = x->failed_for[i] + 0.5 * h > RETRY + PROBE_TIME;
    x->failed_for[i] += h;
    if (ends) {
        const double all = x->asked[i] / (1.0 - FRICTION / PROBE_TORQUE); /* of the whole command */
        x->tried[i] = all > 0.0 ? forth * clip(x->given[i] / all, -1.0, 1.0) : 0.0;
        x->failed_for[i] = fabs(x->tried[i]) > WORKS ? 0.0 : h;
        allocator_bounded_forget(x, i);
    }
}

#endif
