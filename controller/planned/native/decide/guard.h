/* The last look at what leaves the block, whatever was computed before: docs/how/planned-work.md, Taking it into flight
 * software. Requirement: FC-4. Tests: test_guard.py. */
#ifndef CONTROLLER_PLANNED_DECIDE_GUARD_H
#define CONTROLLER_PLANNED_DECIDE_GUARD_H

#include "controller_planned_guard.h"

/*@ predicate is_within(double command, double limit) =
        \le_double(\neg_double(limit), command) && \le_double(command, limit); */
#ifdef __FRAMAC__
/* clang-format off */
#define COMMANDS_WITHIN(p) \
    ensures \result ==> is_within(y->dipole_ff[0], \mul_double((p)->dipole_max, (p)->rod_limits[0])); \
    ensures \result ==> is_within(y->dipole_ff[1], \mul_double((p)->dipole_max, (p)->rod_limits[1])); \
    ensures \result ==> is_within(y->dipole_ff[2], \mul_double((p)->dipole_max, (p)->rod_limits[2])); \
    ensures \result ==> is_within(y->wheel_torque_ff, (p)->wheel_torque_max);
/* clang-format on */
#endif

/* The command within its limit, if it is a finite number. */
//@ assigns *command;
static inline void bring_within(double *command, double limit)
{
    if (is_number(*command) && *command > limit) {
        *command = limit;
    }
    if (is_number(*command) && *command < -limit) {
        *command = -limit;
    }
}

/*@ assigns \nothing;
    ensures \result ==> is_within(command, limit); */
static inline bool is_command(double command, double limit)
{
    return command >= -limit && command <= limit;
}

/*@ assigns \nothing;
    COMMANDS_WITHIN(p) */
static inline bool are_commands(const ControllerPlannedParameters *p, const ControllerPlannedOutputs *y)
{
    return is_command(y->dipole_ff[0], p->dipole_max * p->rod_limits[0]) &&
           is_command(y->dipole_ff[1], p->dipole_max * p->rod_limits[1]) &&
           is_command(y->dipole_ff[2], p->dipole_max * p->rod_limits[2]) &&
           is_command(y->wheel_torque_ff, p->wheel_torque_max);
}

/* Each command is brought within its limit, of three rods and the wheel; outputs that are no finite numbers are
 * refused. */
/*@ requires \separated(p, y, f);
    assigns y->dipole_ff[0 .. 2], y->wheel_torque_ff, *f;
    CONTROLLER_PLANNED_FINITE
    COMMANDS_WITHIN(p) */
static inline bool controller_planned_give(const ControllerPlannedParameters *p, ControllerPlannedOutputs *y, Fault *f)
{
    bring_within(&y->dipole_ff[0], p->dipole_max * p->rod_limits[0]);
    bring_within(&y->dipole_ff[1], p->dipole_max * p->rod_limits[1]);
    bring_within(&y->dipole_ff[2], p->dipole_max * p->rod_limits[2]);
    bring_within(&y->wheel_torque_ff, p->wheel_torque_max);
    if (!controller_planned_guard(y, f)) {
        return false;
    }
    return are_commands(p, y) || fault(f, "dipole_ff", NAN, "commands within their limits");
}

#endif
