/* The last look at the commands, whatever was computed before: docs/how/planned-work.md, Taking it into flight software.
 * Requirement: FC-4. Tests: test_guard.py. */
#include "../state.h"

#include <float.h>

/*@ requires \valid(command);
    assigns *command;
    ensures \result ==> \is_finite(*command) && \le_double((double)(-limit), *command) &&
            \le_double(*command, limit); */
static bool is_command(double *command, double limit)
{
    if (!(*command >= -DBL_MAX && *command <= DBL_MAX)) {
        return false;
    }
    if (*command > limit) {
        *command = limit;
    }
    if (*command < -limit) {
        *command = -limit;
    }
    return *command >= -limit && *command <= limit;
}

/*@ requires \valid(y) && \valid(f) && \valid_read(rod_limits + (0 .. 2));
    requires \separated(y, f, rod_limits + (0 .. 2));
    assigns y->dipole_ff[0 .. 2], y->tau_cmd_B[0 .. 2], y->wheel_torque_ff, *f;
    ensures \result ==> \is_finite(y->dipole_ff[0]) && \le_double(y->dipole_ff[0], rod_limits[0]) &&
            \le_double((double)(-rod_limits[0]), y->dipole_ff[0]);
    ensures \result ==> \is_finite(y->dipole_ff[1]) && \le_double(y->dipole_ff[1], rod_limits[1]) &&
            \le_double((double)(-rod_limits[1]), y->dipole_ff[1]);
    ensures \result ==> \is_finite(y->dipole_ff[2]) && \le_double(y->dipole_ff[2], rod_limits[2]) &&
            \le_double((double)(-rod_limits[2]), y->dipole_ff[2]);
    ensures \result ==> \is_finite(y->wheel_torque_ff) && \le_double(y->wheel_torque_ff, torque_max) &&
            \le_double((double)(-torque_max), y->wheel_torque_ff);
    ensures \result ==> \is_finite(y->tau_cmd_B[0]) && \is_finite(y->tau_cmd_B[1]) && \is_finite(y->tau_cmd_B[2]); */
bool controller_planned_guard(const double rod_limits[3], double torque_max, ControllerPlannedOutputs *y, Fault *f)
{
    static const char *const expected = "a finite number for this output";
    if (!is_command(&y->dipole_ff[0], rod_limits[0]) || !is_command(&y->dipole_ff[1], rod_limits[1]) ||
        !is_command(&y->dipole_ff[2], rod_limits[2])) {
        return fault(f, "dipole_ff", NAN, expected);
    }
    if (!is_command(&y->wheel_torque_ff, torque_max)) {
        return fault(f, "wheel_torque_ff", NAN, expected);
    }
    if (!is_command(&y->tau_cmd_B[0], DBL_MAX) || !is_command(&y->tau_cmd_B[1], DBL_MAX) ||
        !is_command(&y->tau_cmd_B[2], DBL_MAX)) {
        return fault(f, "tau_cmd_B", NAN, expected);
    }
    return true;
}
