/* Wheel torque along the field, least-norm dipoles across it; all commands are held near saturation [14]-[24].
 * Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in Low
 * Earth Orbit (AIAA 2009-5902).
 * Generated from fmus/interfaces/allocator.toml by python -m fmus.native; do not edit. */
#ifndef ALLOCATOR_PORTS_H
#define ALLOCATOR_PORTS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /* frame B; Rows: the rods' unit axes u1, u2, u3 that the allocation assumes [16]; of unit length to 1e-6
     * (normalised on use), linearly independent */
    double rod_axes[3][3];
    /* A.m2; Largest dipole of each rod */
    double dipole_max;
    /* frame B; Unit axis of the wheel that the allocation assumes; of unit length to 1e-6 (normalised on use)
     * */
    double wheel_axis[3];
    /* N.m; Largest torque of the wheel's motor */
    double wheel_torque_max;
    /* N.m.s; Largest |h_w| of the wheel; for tau_residual_B the wheel gives no torque beyond it */
    double wheel_momentum_max;
    /* Share of an actuator's limit at which all commands are held */
    double hold_fraction;
} AllocatorParameters;

typedef struct {
    /* N.m; frame B; Demanded control torque on the body */
    double tau_cmd_B[3];
    /* T; frame B; Geomagnetic field */
    double b_B[3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* N.m.s; Wheel momentum l_w */
    double h_w;
} AllocatorInputs;

typedef struct {
    /* A.m2; frame rods; Commanded dipole of each rod along its axis u_i: m of [24], or the held value */
    double dipole_cmd[3];
    /* N.m; Commanded dl_w/dt, the torque on the rotor: [20], or the held value */
    double wheel_torque_cmd;
    /* All commands keep their last values, because a demand is at or above hold_fraction of its limit or the
     * allocation is singular */
    bool holding;
    /* Largest ratio of an actuator's demand to its limit, before the hold; at most 1e6, and 1e6 where the
     * allocation is singular */
    double demand_fraction;
    /* N.m; frame B; Demand minus the torque on the body that the commands give within the actuators' limits
     * */
    double tau_residual_B[3];
    /* Component of the field's unit vector along the wheel axis; [20] is singular where it is zero */
    double b_wheel;
} AllocatorOutputs;

#endif
