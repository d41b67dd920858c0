/* Modes of a mission: it gives the controller the reference of the present mode, and slews from one to the next.
 * Generated from fmus/interfaces/supervisor.toml by python -m fmus.native; do not edit. */
#ifndef SUPERVISOR_PORTS_H
#define SUPERVISOR_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    SUPERVISOR_SAFE_POINTING_NONE = 1,
    SUPERVISOR_SAFE_POINTING_FIELD = 2,
    SUPERVISOR_SAFE_POINTING_SUN = 3
};

enum {
    SUPERVISOR_FIRST_MODE_NADIR = 1,
    SUPERVISOR_FIRST_MODE_INERTIAL = 2,
    SUPERVISOR_FIRST_MODE_TARGET = 3,
    SUPERVISOR_FIRST_MODE_SUN = 4
};

enum {
    SUPERVISOR_TARGET_YAW_STEERED = 1,
    SUPERVISOR_TARGET_YAW_FREE = 2
};

typedef struct {
    /* kg.m2; frame B; Inertia, from which the slews' largest acceleration follows; symmetric, positive
     * definite, with each principal moment at most the sum of the others */
    double J_B[3][3];
    /* rad/s; Largest rate of a slew relative to its destination */
    double slew_rate_max;
    /* N.m; Largest torque that the turn of a slew may need; what the actuators give at all times, less what
     * else they have to give */
    double slew_torque_max;
    /* s; How far ahead the reference to come is given, anew every 10 s; 0: not at all */
    double ahead_horizon;
    /* 'none': rates damped only; 'field': safe_axis_B along the measured field; 'sun': sun_axis_B to the
     * measured Sun, at rest where it is not seen */
    int32_t safe_pointing;
    /* frame B; Body axis that safe_pointing 'field' turns along the field; of unit length to 1e-6. With the
     * wheel's axis, rods and wheel together give every torque */
    double safe_axis_B[3];
    /* s; Time in which the angle to the direction shrinks by e: the rate asked for is the angle over it, at
     * most slew_rate_max and half of rate_acquire. Longer than that of the controller's rate loop, J/L */
    double safe_time;
    /* Mode that acquisition leads to where none is commanded */
    int32_t first_mode;
    /* rad/s; 'safe' gives way to 'acquire' when the rate has been below this for rate_time and the attitude
     * is known */
    double rate_acquire;
    /* rad/s; Back to 'safe' when the rate has been above this for rate_time; at least rate_acquire */
    double rate_lost;
    /* s; Time for both conditions of the rate */
    double rate_time;
    /* rad; 'acquire' ends when the attitude error has been below this, and the rate error below settled_rate,
     * for settled_time */
    double settled_angle;
    /* rad/s; Rate error that ends 'acquire' */
    double settled_rate;
    /* s; Time for both conditions of the errors */
    double settled_time;
    /* rad; Back to 'acquire' when the attitude error has been above this for angle_time */
    double angle_lost;
    /* s; Time for this condition */
    double angle_time;
    /* s; Back to 'safe' when the attitude has not been known for this time; until then the reference goes on
     * */
    double attitude_time;
    /* Turn about the line of sight: 'steered': as in LVLH, but turned by target_yaw_angle; 'free': none, from
     * the attitude at which the turn to the target begins */
    int32_t target_yaw;
    /* rad; Turn about the line of sight, from the sense of flight, for 'steered' */
    double target_yaw_angle;
    /* frame B; Body axis that points to the Sun in the mode 'sun'; of unit length to 1e-6 */
    double sun_axis_B[3];
    /* UTC at t = 0, ISO 8601, with the time of day, in the years 1900 to 2100; with Z, +00:00, -00:00 or no
     * zone at its end */
    char epoch[128];
    /* m3/s2; mu of the Earth (WGS 84), for the acceleration of the line of sight */
    double gravitational_parameter;
} SupervisorParameters;

typedef struct {
    /* frame N from B; Attitude, x_N = R_NB x_B; orthonormal to 1e-4. A matrix of zeros: no attitude */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass */
    double v_N[3];
    /* Whether R_NB can be trusted */
    bool attitude_valid;
    /* Mode that is asked for: 1 safe, 3 nadir, 4 inertial, 6 target, 7 sun; 0: that of the parameter
     * first_mode; optional; -1 means not connected */
    int32_t command;
    /* frame N from desired body; Attitude of the mode 'inertial', orthonormal to 1e-4; optional; 1e9 means
     * not connected */
    double R_goal[3][3];
    /* rad; Geodetic latitude (WGS 84) of the point on the Earth of the mode 'target', -π/2 to π/2; optional;
     * 1e9 means not connected */
    double target_latitude;
    /* rad; Its longitude, positive to the east, -2π to 2π; optional; 1e9 means not connected */
    double target_longitude;
    /* m; Its height above the ellipsoid, -12 km to 1000 km; optional; 1e9 means not connected */
    double target_height;
    /* frame N; Unit vector to the Sun, for the mode 'sun'; optional; 1e9 means not connected */
    double sun_N[3];
    /* Share of the Sun that is seen, 0 to 1: below 0.5 the mode 'sun' gives way to 'nadir'; optional; 1e9
     * means not connected */
    double sunlight;
    /* T; frame B; Measured field, for safe_pointing 'field'; a vector of zeros is no measurement; optional;
     * 1e9 means not connected */
    double b_B[3];
    /* frame B; Measured direction to the Sun, of any length, for safe_pointing 'sun'; a vector of zeros is no
     * measurement; optional; 1e9 means not connected */
    double sun_B[3];
} SupervisorInputs;

typedef struct {
    /* frame N from desired body; Desired attitude; a matrix of zeros: no reference, follow the rate Omega_ref
     * only */
    double R_ref[3][3];
    /* rad/s; frame desired body; Desired body rate; without desired attitude in the body's own axes */
    double Omega_ref[3];
    /* rad/s2; frame desired body; Time derivative of Omega_ref */
    double dOmega_ref[3];
    /* s; Times from now at which the reference to come is given, ascending; zeros: it is not given */
    double t_ahead[16];
    /* rad; frame N; Desired attitude at these times, each as the rotation vector φ of exp(φ^), N from desired
     * body */
    double turn_ahead[16][3];
    /* rad/s; frame desired body; Desired body rate at these times */
    double Omega_ahead[16][3];
    /* 1 safe, 2 acquire, 3 nadir, 4 inertial, 5 slew, 6 target, 7 sun */
    int32_t mode;
    /* The mode that acquisition or slew leads to; else the mode itself */
    int32_t destination;
    /* s; Time to the end of the slew; 0 in other modes */
    double slew_remaining;
    /* rad; Elevation of the satellite above the horizon of the target; -pi/2 where no target is given */
    double target_elevation;
} SupervisorOutputs;

/* An optional input is not connected where an element is this large. */
#define SUPERVISOR_ABSENT_MIN 999000000.0

static inline bool supervisor_has_command(const SupervisorInputs *u)
{
    return !(u->command < 0);
}

static inline bool supervisor_has_R_goal(const SupervisorInputs *u)
{
    return !(fabs(u->R_goal[0][0]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[0][1]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[0][2]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[1][0]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[1][1]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[1][2]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[2][0]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[2][1]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->R_goal[2][2]) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_target_latitude(const SupervisorInputs *u)
{
    return !(fabs(u->target_latitude) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_target_longitude(const SupervisorInputs *u)
{
    return !(fabs(u->target_longitude) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_target_height(const SupervisorInputs *u)
{
    return !(fabs(u->target_height) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_sun_N(const SupervisorInputs *u)
{
    return !(fabs(u->sun_N[0]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->sun_N[1]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->sun_N[2]) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_sunlight(const SupervisorInputs *u)
{
    return !(fabs(u->sunlight) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_b_B(const SupervisorInputs *u)
{
    return !(fabs(u->b_B[0]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->b_B[1]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->b_B[2]) >= SUPERVISOR_ABSENT_MIN);
}

static inline bool supervisor_has_sun_B(const SupervisorInputs *u)
{
    return !(fabs(u->sun_B[0]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->sun_B[1]) >= SUPERVISOR_ABSENT_MIN ||
             fabs(u->sun_B[2]) >= SUPERVISOR_ABSENT_MIN);
}

#endif
