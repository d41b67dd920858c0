/* Bounded least squares over wheel and rods: the torque nearest to the demand within the limits; commands are never held.
 * Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in Low
 * Earth Orbit (AIAA 2009-5902).
 * Generated from fmus/interfaces/allocator_bounded.toml by python -m fmus.native; do not edit. */
#ifndef ALLOCATOR_BOUNDED_PORTS_H
#define ALLOCATOR_BOUNDED_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /* frame B; Rows: the rods' unit axes u1, u2, u3 that the allocation assumes [16]; of unit length to 1e-6
     * (normalised on use), linearly independent */
    double rod_axes[3][3];
    /* A.m2; Largest dipole of each rod; rod_limits has the share of it that each one gives */
    double dipole_max;
    /* Largest dipole of each rod over dipole_max, such as 0.4 for an air coil beside two rods with a core */
    double rod_limits[3];
    /* frame B; Unit axis of the wheel that the allocation assumes; of unit length to 1e-6 (normalised on use)
     * */
    double wheel_axis[3];
    /* N.m; Largest torque of the wheel's motor */
    double wheel_torque_max;
    /* N.m.s; Largest |h_w| of the wheel */
    double wheel_momentum_max;
    /* s; Time for which a command is applied, at least the step of the loop; within it no commanded wheel
     * torque takes h_w beyond wheel_momentum_max */
    double command_period;
    /* s; Time constant with which the wheel is preferably brought to rest where wheel_torque_ff is not
     * connected */
    double desaturation_time;
    /* T; Torque error, in N m, that costs as much as a deviation of 1 A m2 from a rod's preferred dipole; in
     * fields near this value or below it the rods are hardly used */
    double rod_weight;
    /* Torque error, in N m, that costs as much as a deviation of 1 N m of the wheel torque from
     * -h_w/desaturation_time */
    double wheel_weight;
    /* Torque error, in N m, that costs as much as a deviation of 1 N m of the wheel torque from
     * wheel_torque_ff */
    double wheel_weight_ff;
} AllocatorBoundedParameters;

typedef struct {
    /* N.m; frame B; Demanded control torque on the body */
    double tau_cmd_B[3];
    /* T; frame B; Geomagnetic field; below 1e-12 T only the wheel acts */
    double b_B[3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* N.m.s; Wheel momentum l_w */
    double h_w;
    /* A.m2; frame rods; Feed-forward: the preferred dipoles, where several dipoles meet the demand equally
     * well; zero if not connected; optional; 1e9 means not connected */
    double dipole_ff[3];
    /* N.m; Feed-forward: the preferred dl_w/dt; -h_w/desaturation_time if not connected; optional; 1e9 means
     * not connected */
    double wheel_torque_ff;
    /* What each rod gives of its commanded dipole, as it is known: 0 for a dead rod, negative for a reversed
     * one; 1 if not connected; optional; 1e9 means not connected */
    double rod_gains[3];
} AllocatorBoundedInputs;

typedef struct {
    /* A.m2; frame rods; Commanded dipole of each rod along its axis u_i, within dipole_max times rod_limits
     * */
    double dipole_cmd[3];
    /* N.m; Commanded dl_w/dt, the torque on the rotor; within wheel_torque_max, and such that h_w stays
     * within its limit */
    double wheel_torque_cmd;
    /* Always false: this allocator has a command at every attitude and never holds the last command */
    bool holding;
    /* Largest ratio of an actuator's command to its limit, computed without limits: above 1 a limit acts; at
     * most 1e6 */
    double demand_fraction;
    /* N.m; frame B; Demand minus the torque that the commands give on the body */
    double tau_residual_B[3];
    /* Component of the field's unit vector along the wheel axis; where it is near zero, a demand along the
     * field is not met */
    double b_wheel;
} AllocatorBoundedOutputs;

/* An optional input is not connected where an element is this large. */
#define ALLOCATOR_BOUNDED_ABSENT_MIN 999000000.0

static inline bool allocator_bounded_has_dipole_ff(const AllocatorBoundedInputs *u)
{
    return !(fabs(u->dipole_ff[0]) >= ALLOCATOR_BOUNDED_ABSENT_MIN ||
             fabs(u->dipole_ff[1]) >= ALLOCATOR_BOUNDED_ABSENT_MIN ||
             fabs(u->dipole_ff[2]) >= ALLOCATOR_BOUNDED_ABSENT_MIN);
}

static inline bool allocator_bounded_has_wheel_torque_ff(const AllocatorBoundedInputs *u)
{
    return !(fabs(u->wheel_torque_ff) >= ALLOCATOR_BOUNDED_ABSENT_MIN);
}

static inline bool allocator_bounded_has_rod_gains(const AllocatorBoundedInputs *u)
{
    return !(fabs(u->rod_gains[0]) >= ALLOCATOR_BOUNDED_ABSENT_MIN ||
             fabs(u->rod_gains[1]) >= ALLOCATOR_BOUNDED_ABSENT_MIN ||
             fabs(u->rod_gains[2]) >= ALLOCATOR_BOUNDED_ABSENT_MIN);
}

#endif
