/* Generated from interface.toml; do not edit. */
#include "instance.h"

#include <float.h>

#define ROW(name, member, kind, causality, variability, start, min, max, text, followers) \
    {name, text, start, min, max, (uint32_t)offsetof(Ports, member), kind, causality, variability, followers},

const Variable variables[BLOCK_VARIABLES] = {
    ROW("torque_request[1]", u.torque_request[0], KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 9)
    ROW("torque_request[2]", u.torque_request[1], KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 8)
    ROW("torque_request[3]", u.torque_request[2], KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 7)
    ROW("mag_x", u.mag_x, KIND_REAL, CAUSALITY_INPUT, MOVING, -10000.0, -DBL_MAX, DBL_MAX, NULL, 6)
    ROW("mag_y", u.mag_y, KIND_REAL, CAUSALITY_INPUT, MOVING, 20000.0, -DBL_MAX, DBL_MAX, NULL, 5)
    ROW("mag_z", u.mag_z, KIND_REAL, CAUSALITY_INPUT, MOVING, -30000.0, -DBL_MAX, DBL_MAX, NULL, 4)
    ROW("gyro[1]", u.gyro[0], KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 3)
    ROW("gyro[2]", u.gyro[1], KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 2)
    ROW("gyro[3]", u.gyro[2], KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 1)
    ROW("tach", u.tach, KIND_REAL, CAUSALITY_INPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 0)
    ROW("coil[1]", y.coil[0], KIND_REAL, CAUSALITY_OUTPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 4)
    ROW("coil[2]", y.coil[1], KIND_REAL, CAUSALITY_OUTPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 3)
    ROW("coil[3]", y.coil[2], KIND_REAL, CAUSALITY_OUTPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 2)
    ROW("wheel_motor", y.wheel_motor, KIND_REAL, CAUSALITY_OUTPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 1)
    ROW("field_on_wheel", y.field_on_wheel, KIND_REAL, CAUSALITY_OUTPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 0)
    ROW("coils_on", y.coils_on, KIND_BOOLEAN, CAUSALITY_OUTPUT, MOVING, 0.0, -DBL_MAX, DBL_MAX, NULL, 0)
    ROW("coil_max", p.coil_max, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 25000.0, 1.0, DBL_MAX, NULL, 0)
    ROW("coil_step", p.coil_step, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 100.0, 0.0, DBL_MAX, NULL, 1)
    ROW("coil_dead_band", p.coil_dead_band, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 50.0, 0.0, DBL_MAX, NULL, 0)
    ROW("cycle", p.cycle, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 2.0, 0.01, DBL_MAX, NULL, 0)
    ROW("off_time", p.off_time, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 0.1, 0.0, DBL_MAX, NULL, 0)
    ROW("rotor_inertia", p.rotor_inertia, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 147.0, 0.001, DBL_MAX, NULL, 0)
    ROW("motor_max", p.motor_max, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 3.0, 1e-06, DBL_MAX, NULL, 0)
    ROW("friction_coulomb", p.friction_coulomb, KIND_REAL, CAUSALITY_PARAMETER, TUNABLE, 0.0, 0.0, DBL_MAX, NULL, 1)
    ROW("friction_viscous", p.friction_viscous, KIND_REAL, CAUSALITY_PARAMETER, TUNABLE, 0.0, 0.0, DBL_MAX, NULL, 0)
    ROW("sample_period", sampling.sample_period, KIND_REAL, CAUSALITY_PARAMETER, FIXED, 0.0, 0.0, DBL_MAX, NULL, 0)
};
