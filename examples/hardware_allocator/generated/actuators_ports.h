/* Magnetorquer and reaction wheel drivers: quantised rods with off-time for the magnetometer, wheel with friction compensation.
 * Generated from interface.toml; do not edit. */
#ifndef ACTUATORS_PORTS_H
#define ACTUATORS_PORTS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    /* mA.m2; Largest dipole of a coil */
    double coil_max;
    /* mA.m2; Least significant bit of a driver */
    double coil_step;
    /* mA.m2; Dead band: a smaller dipole is set to zero */
    double coil_dead_band;
    /* s; Period of the magnetometer's readings */
    double cycle;
    /* s; Time at the end of each period in which the coils are off; in the rest of the period the dipole is
     * larger, so that its mean is kept */
    double off_time;
    /* g.cm2; Inertia of the wheel's rotor */
    double rotor_inertia;
    /* mN.m; Largest torque of the motor */
    double motor_max;
    /* mN.m; Coulomb friction that is compensated */
    double friction_coulomb;
    /* uN.m/rpm; Viscous friction that is compensated */
    double friction_viscous;
} ActuatorsParameters;

typedef struct {
    /* mN.m; frame spacecraft body; Torque that the attitude law demands */
    double torque_request[3];
    /* nT; frame magnetometer: x is body -y, y is body x, z is body z; Magnetometer reading, x */
    double mag_x;
    /* nT; frame magnetometer; Magnetometer reading, y */
    double mag_y;
    /* nT; frame magnetometer; Magnetometer reading, z */
    double mag_z;
    /* deg/s; frame spacecraft body; Gyro reading */
    double gyro[3];
    /* rpm; Wheel tachometer */
    double tach;
} ActuatorsInputs;

typedef struct {
    /* mA.m2; frame drivers: coil 1 drives the third rod, coil 2 the first, coil 3 the second; Dipole that
     * each driver is set to */
    double coil[3];
    /* mN.m; Motor torque on the body, friction compensation included: a positive torque slows the wheel */
    double wheel_motor;
    /* Component of the field's direction along the wheel axis */
    double field_on_wheel;
    /* True while the coils are powered; false while the magnetometer is read */
    bool coils_on;
} ActuatorsOutputs;

#endif
