/* The last look at the commands, whatever was computed before: docs/how/planned-work.md, Taking it into flight software.
 * Requirement: FC-4. Tests: test_guard.py. */
#include "../state.h"

#include <float.h>

/*@ assigns \nothing;
    ensures \result ==> \is_finite(command) && \le_double(low, command) && \le_double(command, high); */
static inline bool is_command(double command, double low, double high)
{
    return command >= -DBL_MAX && command <= DBL_MAX && command >= low && command <= high;
}

/* The command within its limit, if it is a finite number; then whether it is one. */
/*@ requires \valid(command);
    assigns *command;
    ensures \result ==> \is_finite(*command) && \le_double(low, *command) && \le_double(*command, high); */
static bool bring_within(double *command, double low, double high)
{
    if (!(*command >= -DBL_MAX && *command <= DBL_MAX)) {
        return false;
    }
    if (*command > high) {
        *command = high;
    }
    if (*command < low) {
        *command = low;
    }
    return is_command(*command, low, high);
}

/*@ predicate is_within(double command, double limit) =
        \is_finite(command) && \le_double(\neg_double(limit), command) && \le_double(command, limit); */

/*@ requires \valid_read(rod_limits + (0 .. 2)) && \valid(y) && \valid(f);
    requires \separated(rod_limits + (0 .. 2), y, f);
    assigns y->dipole_ff[0 .. 2], y->wheel_torque_ff, y->tau_cmd_B[0 .. 2], *f;
    ensures \result ==> is_within(y->dipole_ff[0], rod_limits[0]);
    ensures \result ==> is_within(y->dipole_ff[1], rod_limits[1]);
    ensures \result ==> is_within(y->dipole_ff[2], rod_limits[2]);
    ensures \result ==> is_within(y->wheel_torque_ff, torque_max);
    ensures \result ==> \is_finite(y->tau_cmd_B[0]) && \is_finite(y->tau_cmd_B[1]) && \is_finite(y->tau_cmd_B[2]); */
bool controller_planned_limits(const double rod_limits[3], double torque_max, ControllerPlannedOutputs *y, Fault *f)
{
    static const char *const expected = "a finite number for this output";
    if (!bring_within(&y->dipole_ff[0], -rod_limits[0], rod_limits[0]) ||
        !bring_within(&y->dipole_ff[1], -rod_limits[1], rod_limits[1]) ||
        !bring_within(&y->dipole_ff[2], -rod_limits[2], rod_limits[2])) {
        return fault(f, "dipole_ff", NAN, expected);
    }
    if (!bring_within(&y->wheel_torque_ff, -torque_max, torque_max)) {
        return fault(f, "wheel_torque_ff", NAN, expected);
    }
    if (!bring_within(&y->tau_cmd_B[0], -DBL_MAX, DBL_MAX) || !bring_within(&y->tau_cmd_B[1], -DBL_MAX, DBL_MAX) ||
        !bring_within(&y->tau_cmd_B[2], -DBL_MAX, DBL_MAX)) {
        return fault(f, "tau_cmd_B", NAN, expected);
    }
    return true;
}
