/* Rigid satellite with one reaction wheel and three magnetic torquers on a low Earth orbit.
 * Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in Low
 * Earth Orbit (AIAA 2009-5902).
 * Generated from fmus/interfaces/plant.toml by python -m fmus.native; do not edit. */
#ifndef PLANT_PORTS_H
#define PLANT_PORTS_H

#include <stdbool.h>
#include <stdint.h>

enum {
    PLANT_ORBIT_START_CIRCULAR = 1,
    PLANT_ORBIT_START_POSITION_VELOCITY = 2
};

enum {
    PLANT_BODY_AXIS_X = 1,
    PLANT_BODY_AXIS_Y = 2,
    PLANT_BODY_AXIS_Z = 3
};

enum {
    PLANT_FIELD_MODEL_IGRF14 = 1,
    PLANT_FIELD_MODEL_WMM2010 = 2,
    PLANT_FIELD_MODEL_WMM2015 = 3,
    PLANT_FIELD_MODEL_WMM2020 = 4,
    PLANT_FIELD_MODEL_WMM2025 = 5
};

enum {
    PLANT_INITIAL_ATTITUDE_Q0 = 1,
    PLANT_INITIAL_ATTITUDE_Q_NB0 = 2
};

typedef struct {
    /* kg.m2; frame B; Inertia with the wheel locked; symmetric, positive definite, with each principal moment
     * at most the sum of the others */
    double J_B[3][3];
    /* kg.m2; frame B; Difference of the true inertia from J_B: the plant moves with J_B + J_error_B */
    double J_error_B[3][3];
    /* kg.m2; Inertia of the wheel about wheel_axis */
    double wheel_inertia;
    /* frame B; Unit axis of the wheel; of unit length to 1e-6 (normalised on use) */
    double wheel_axis[3];
    /* N.m.s; Largest |h_w| of the wheel */
    double wheel_momentum_max;
    /* N.m; Largest torque of the wheel's motor */
    double wheel_torque_max;
    /* N.m.s/rad; Viscous friction of the wheel's bearing */
    double wheel_viscous_friction;
    /* N.m; Coulomb friction of the wheel's bearing; a wheel at rest stays at rest under smaller motor torques
     * */
    double wheel_coulomb_friction;
    /* A.m2; Largest dipole of each rod; rod_limits has the share of it that each one gives */
    double dipole_max;
    /* Largest dipole of each rod over dipole_max, such as 0.4 for an air coil beside two rods with a core */
    double rod_limits[3];
    /* frame B; Rows: the rods' unit axes u1, u2, u3 [16]; of unit length to 1e-6 (normalised on use) */
    double rod_axes[3][3];
    /* Ratio of each rod's dipole to its command, which is clipped at its limit first: 0 for a dead rod, -1
     * for a reversed one */
    double rod_gain[3];
    /* s; Period in which the rods are first on and then off, so that the field can be measured, from t = 0.
     * 0: the rods are always on; otherwise at least 1 ms */
    double rod_period;
    /* Fraction of each rod_period, from its start, in which the rods are on; in the rest of it they give no
     * dipole */
    double rod_duty;
    /* A.m2; frame B; Dipole of the satellite itself */
    double residual_dipole_B[3];
    /* N.m; frame B; Constant external moment in body axes */
    double disturbance_torque_B[3];
    /* Which start values give the orbit: orbit_radius, inclination, node_longitude and argument_of_latitude,
     * or r_N0 and v_N0 */
    int32_t orbit_start;
    /* m; Radius of the circular orbit */
    double orbit_radius;
    /* rad; Inclination of the orbit */
    double inclination;
    /* rad; frame Earth-fixed; East longitude of the ascending node at t = 0; RAAN = GMST(epoch) +
     * node_longitude */
    double node_longitude;
    /* rad; Angle from the ascending node to the satellite at t = 0 */
    double argument_of_latitude;
    /* m; frame N; Position at t = 0 for orbit_start 'position_velocity'; the perigee must lie above 100 km */
    double r_N0[3];
    /* m/s; frame N; Velocity at t = 0 for orbit_start 'position_velocity' */
    double v_N0[3];
    /* Whether the orbit's plane drifts with J2's secular node rate */
    bool j2_node_drift;
    /* UTC at t = 0, ISO 8601, with the time of day; with Z, +00:00, -00:00 or no zone at its end */
    char epoch[128];
    /* m3/s2; mu of the Earth (WGS 84) */
    double gravitational_parameter;
    /* Whether the gravity-gradient moment acts */
    bool gravity_gradient;
    /* Whether the aerodynamic moment acts; it needs an orbit between 150 and 2000 km */
    bool drag;
    /* Factor on the aerodynamic moment */
    double drag_factor;
    /* C_d of each plate */
    double drag_coefficient;
    /* m; Width of the octagonal cylinder across its flats */
    double body_width;
    /* m; Length of the octagonal cylinder */
    double body_length;
    /* Body axis along the octagonal cylinder; four of its sides face along the two other axes */
    int32_t body_axis;
    /* m; frame B; Position of the centre of mass relative to the cylinder's geometric centre */
    double center_of_mass_B[3];
    /* Solar radio flux F10.7 of the day before, 1e-22 W/(m2 Hz) */
    double f107;
    /* Mean of F10.7 over 81 days, 1e-22 W/(m2 Hz) */
    double f107_average;
    /* Planetary geomagnetic index Ap, daily mean */
    double ap;
    /* Geomagnetic field model; its years must cover the epoch */
    int32_t field_model;
    /* Highest degree of the spherical harmonics of the field that is used (WMM has 12, IGRF 13) */
    int32_t field_degree;
    /* Accept an epoch outside the model's years and extrapolate its secular variation */
    bool field_extrapolate;
    /* Which start value gives the attitude at t = 0 */
    int32_t initial_attitude;
    /* frame L from B; Attitude relative to LVLH at t = 0, R = R_LVLH Q0; orthonormal to 1e-3, projected onto
     * SO(3) */
    double Q0[3][3];
    /* frame N from B; Attitude relative to N at t = 0, scalar first; of unit length to 1e-3, normalised */
    double q_NB0[4];
    /* rad/s; frame B; Body rate relative to N at t = 0 */
    double omega_B0[3];
    /* N.m.s; Wheel momentum at t = 0; within wheel_momentum_max */
    double h_w0;
    /* Order of the Lie group variational integrator: 2, or compositions of it of order 4 (Suzuki) and 6
     * (Yoshida) */
    int32_t integrator_order;
    /* s; Largest internal step; a communication step is divided into equal parts no longer than this */
    double step_max;
} PlantParameters;

typedef struct {
    /* A.m2; frame rods; Demanded dipole of each rod along its axis u_i; clipped at dipole_max times
     * rod_limits */
    double dipole_cmd[3];
    /* N.m; Demanded dl_w/dt, the torque on the rotor: a positive torque raises h_w, and the body receives the
     * opposite torque; clipped at wheel_torque_max */
    double wheel_torque_cmd;
} PlantInputs;

typedef struct {
    /* frame N from B; Attitude: maps body components to inertial ones, x_N = R_NB x_B [1] */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass */
    double v_N[3];
    /* T; frame B; Geomagnetic field */
    double b_B[3];
    /* N.m.s; Wheel momentum l_w: wheel_inertia times the wheel's speed relative to the body [12] */
    double h_w;
    /* frame N from B; Attitude as a unit quaternion, scalar first and not negative */
    double q_NB[4];
    /* N.m; frame B; Gravity-gradient moment M_g [2] */
    double tau_gg_B[3];
    /* N.m; frame B; Aerodynamic moment M_ad on the body's plates, drag_factor included; zero with drag false
     * [2] */
    double tau_drag_B[3];
    /* N.m; frame B; Moment of the rods' and the residual dipole in the field [16] */
    double tau_mag_B[3];
    /* A.m2; frame rods; Dipole of each rod at this instant: rod_gain times the command clipped at dipole_max
     * times rod_limits; zero while the rods are off. In a record, its command is the one that acted before
     * the time stamp, over the step that ends there */
    double dipole[3];
    /* N.m; True dl_w/dt: the command clipped at wheel_torque_max, minus friction; zero where it would drive
     * h_w beyond its limit */
    double wheel_torque;
    /* rad/s; Wheel speed relative to the body */
    double wheel_speed;
    /* N.m.s; frame N; Total angular momentum R (J Omega + l_w wheel_axis) [12]; constant without external
     * moments, for every motion of the wheel */
    double H_N[3];
    /* J; 1/2 Omega.J Omega + U(R) - omega_o.(R Pi): conserved on a circular orbit under gravity gradient
     * alone with constant h_w; with gravity_gradient false it is 1/2 Omega.J Omega, conserved without moments
     * and with constant h_w */
    double energy;
    /* kg/m3; Density of the air at the satellite (NRLMSISE-00, hot oxygen included); zero with drag false */
    double density;
    /* A demanded dipole is beyond dipole_max times rod_limits and is clipped */
    bool dipole_saturated;
    /* The demanded wheel torque is beyond wheel_torque_max and is clipped */
    bool wheel_torque_saturated;
    /* h_w is at its limit and the demanded torque would drive it further */
    bool wheel_momentum_saturated;
    /* The epoch lies outside the years that field_model covers, and field_extrapolate accepts it */
    bool field_extrapolated;
    /* A.m2; frame rods; Mean of the dipole that each rod gave over the last step, the time in which the rods
     * were off included; zero before the first step */
    double dipole_mean[3];
    /* frame N; Unit vector from the satellite to the Sun: its apparent direction, aberration included */
    double sun_N[3];
    /* Part of the Sun's disc that the Earth leaves visible: 1 in full light, 0 in the umbra, between them in
     * the penumbra */
    double sunlight;
} PlantOutputs;

#endif
