/* Acquisition and hold within the actuators' limits: momentum steering, receding-horizon plan, tracking of the plan by law [8].
 * Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in Low
 * Earth Orbit (AIAA 2009-5902).
 * Generated from fmus/interfaces/controller_planned.toml by python -m fmus.native; do not edit. */
#ifndef CONTROLLER_PLANNED_PORTS_H
#define CONTROLLER_PLANNED_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    CONTROLLER_PLANNED_FIELD_MODEL_IGRF14 = 1,
    CONTROLLER_PLANNED_FIELD_MODEL_WMM2010 = 2,
    CONTROLLER_PLANNED_FIELD_MODEL_WMM2015 = 3,
    CONTROLLER_PLANNED_FIELD_MODEL_WMM2020 = 4,
    CONTROLLER_PLANNED_FIELD_MODEL_WMM2025 = 5
};

enum {
    CONTROLLER_PLANNED_REFERENCE_LVLH = 1,
    CONTROLLER_PLANNED_REFERENCE_INERTIAL = 2,
    CONTROLLER_PLANNED_REFERENCE_RATE = 3
};

typedef struct {
    /* kg.m2; frame B; Initial estimate of the inertia; symmetric, positive definite, with each principal
     * moment at most the sum of the others */
    double J_B[3][3];
    /* N.m; Diagonal of K, 0 < K0[1] < K0[2] < K0[3] [9]; all zero: computed from the satellite's data */
    double K0[3];
    /* N.m.s; frame B; L, symmetric and positive definite [9], below 2 J_B/control_period about each axis; all
     * zero: computed from the satellite's data */
    double L0[3][3];
    /* s; Time between two samples of the control; between them all outputs are held. At most a fifth of T =
     * √(J/(dipole_max B)), in which the rods turn the satellite; J is the mean moment of inertia, at most ten
     * times the least one */
    double control_period;
    /* frame B; Rows: the rods' unit axes u1, u2, u3 that the plan assumes [16]; of unit length to 1e-6,
     * linearly independent */
    double rod_axes[3][3];
    /* What each rod is known to give of its command before the flight: 1 sound, 0 dead, negative reversed. A
     * gain of 0 is kept as it is; the others are identified from these values */
    double rod_gains0[3];
    /* A.m2; Largest dipole of each rod; rod_limits has the share of it that each one gives */
    double dipole_max;
    /* Largest dipole of each rod over dipole_max, such as 0.4 for an air coil beside two rods with a core */
    double rod_limits[3];
    /* frame B; Unit axis of the wheel; of unit length to 1e-6 (normalised on use) */
    double wheel_axis[3];
    /* N.m; Largest torque of the wheel's motor */
    double wheel_torque_max;
    /* N.m.s; Largest |h_w| of the wheel */
    double wheel_momentum_max;
    /* s; Time between two plans; zero: computed from the satellite's data */
    double plan_period;
    /* Iterations in one sample of a search for a plan (180 in all), at most; the work of a sample is bounded
     * besides. A smaller value makes each call shorter, and the search takes more samples */
    int32_t search_iterations;
    /* N.m.s; Steering ends, and the plan begins, below this distance from the target's momentum; zero:
     * computed from the satellite's data */
    double steering_limit;
    /* Twice what a wheel momentum of wheel_momentum_max costs a plan per second; a tenth keeps the attitude
     * nearer to the target under a lasting disturbance, with more momentum in the wheel */
    double momentum_weight;
    /* rad; Standard deviation of the measured attitude about each axis, as the estimator assumes it */
    double attitude_noise;
    /* rad/s; Standard deviation of the measured rate in each axis, as the estimator assumes it */
    double rate_noise;
    /* s; Time over which old data lose their weight in the estimate of the disturbance; zero: computed from
     * the orbit's height */
    double disturbance_time;
    /* N.m; Upper bound of the estimated disturbance torque; negative: computed from the satellite's data */
    double disturbance_max;
    /* A.m2; Upper bound of the estimated dipole of the satellite itself; negative: computed from dipole_max
     * */
    double residual_dipole_max;
    /* rad/s; Upper bound of the estimated bias of the measured rate; zero: the bias is not estimated, as
     * where an estimator has removed it */
    double rate_bias_max;
    /* Whether inertia, rod gains and friction of the wheel are identified in flight */
    bool identify;
    /* Relative standard deviation of the initial inertia and rod gains */
    double identify_spread;
    /* Whether failed rods and sensors are looked for and flown without. Set it to false where an estimator
     * gives attitude, rate and field: their errors are not those of sensors */
    bool find_failures;
    /* m3/s2; mu of the Earth (WGS 84) */
    double gravitational_parameter;
    /* UTC at t = 0, ISO 8601, with the time of day; with Z, +00:00, -00:00 or no zone at its end */
    char epoch[128];
    /* Onboard model of the geomagnetic field, at the year of epoch */
    int32_t field_model;
    /* Degree to which the onboard field is evaluated; 1 is a tilted dipole */
    int32_t field_degree;
    /* T; Deliberate error for tests, added to g10, g11, h11 of the onboard field model */
    double field_error[3];
    /* 'lvlh': hold R_d0 relative to LVLH, from r_N and v_N; 'inertial': hold R_d0 in N; 'rate' belongs to the
     * block controller and is refused here */
    int32_t reference;
    /* frame LVLH or N from desired body; Desired attitude: relative to LVLH for 'lvlh', in N for 'inertial';
     * orthonormal to 1e-3, projected onto SO(3) */
    double R_d0[3][3];
} ControllerPlannedParameters;

typedef struct {
    /* frame N from B; Attitude, x_N = R_NB x_B; orthonormal to 1e-4 (single precision is sufficient) */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass */
    double v_N[3];
    /* N.m.s; Wheel momentum l_w; connect it if possible. If not connected, the controller computes it from
     * its own commands; optional; 1e9 means not connected */
    double h_w;
    /* T; frame B; Measured geomagnetic field; corrects the onboard field model. If not connected, the model
     * is used alone; optional; 1e9 means not connected */
    double b_B[3];
    /* A.m2, A.m2, A.m2, N.m; Commands of rods (along their axes) and wheel (dl_w/dt) over the last
     * control_period; their mean if the allocator is stepped more often. If not connected, the estimates use
     * what the controller asked for; optional; 1e9 means not connected */
    double u_applied[4];
    /* frame N from desired body; Target attitude, orthonormal to 1e-4; with Omega_ref and dOmega_ref it takes
     * the place of the parameter reference. A matrix of zeros: no reference now, only the rate follows
     * Omega_ref; optional; 1e9 means not connected */
    double R_ref[3][3];
    /* rad/s; frame desired body; Body rate of the target; connect R_ref, Omega_ref and dOmega_ref, or none of
     * them; optional; 1e9 means not connected */
    double Omega_ref[3];
    /* rad/s2; frame desired body; Time derivative of Omega_ref; optional; 1e9 means not connected */
    double dOmega_ref[3];
    /* s; Times from now at which the target to come is known, ascending, zeros at the end where there are
     * fewer; with turn_ahead and Omega_ahead. All zeros: it is not known; optional; 1e9 means not connected
     * */
    double t_ahead[16];
    /* rad; frame N; Target attitude at these times, each as the rotation vector φ of exp(φ^), N from desired
     * body; optional; 1e9 means not connected */
    double turn_ahead[16][3];
    /* rad/s; frame desired body; Body rate of the target at these times; optional; 1e9 means not connected */
    double Omega_ahead[16][3];
} ControllerPlannedInputs;

typedef struct {
    /* N.m; frame B; Demanded control torque on the body: law [8] on the plan */
    double tau_cmd_B[3];
    /* A.m2; frame rods; Feed-forward: the dipoles of the plan, each along its rod axis u_i */
    double dipole_ff[3];
    /* N.m; Feed-forward: dl_w/dt of the plan */
    double wheel_torque_ff;
    /* rad; Principal angle between the attitude and the target (not the plan) */
    double attitude_error;
    /* rad/s; frame B; Body rate minus the rate of the target (not of the plan) */
    double rate_error_B[3];
    /* J; V = 1/2 omega.J omega + tr(K - K Q) with the errors relative to the plan [11] */
    double lyapunov;
    /* k, scale of the attitude gain: always 1 */
    double gain_k;
    /* l, scale of the rate gain: always 1 */
    double gain_l;
    /* frame N from desired body; Attitude of the plan */
    double R_d[3][3];
    /* rad/s; frame desired body; Body rate of the plan */
    double Omega_d[3];
    /* rad/s2; frame desired body; Time derivative of Omega_d */
    double dOmega_d[3];
    /* N.m.s; Wheel momentum of the plan */
    double h_w_ref;
    /* Cost of the present plan; zero during steering, -1 where the satellite turns too fast for a plan */
    double plan_cost;
    /* 1: steering of the total momentum; 2: acquisition by plan; 3: hold; 4: damping of rates alone, without
     * attitude or reference */
    int32_t phase;
    /* N.m; frame B; Estimated disturbance torque */
    double disturbance_B[3];
    /* A.m2; frame B; Estimated dipole of the satellite itself */
    double residual_dipole_estimate_B[3];
    /* kg.m2; frame B; Estimated inertia, as the plan uses it */
    double J_estimate_B[3][3];
    /* kg.m2; frame B; Standard deviation of each element of the estimated inertia */
    double J_estimate_sigma_B[3][3];
    /* Estimated ratio of the rods' dipole to the commanded dipole, the mean of the three rods */
    double rod_gain_estimate;
    /* The same of each rod */
    double rod_gains_estimate[3];
    /* A rod is dead, weak or reversed: its gain is more than 0.4 from rod_gains0, and known to 0.15 */
    bool rod_failed;
    /* The rod that has failed, 1 to 3; of several the one whose gain is farthest from 1; 0: none */
    int32_t failed_rod;
    /* The wheel is stuck or drags: it has given less than half of the torque that was commanded. Needs h_w
     * and u_applied */
    bool wheel_failed;
    /* R_NB stays the same while omega_B turns the satellite; until it changes the attitude is that of the
     * rate */
    bool attitude_frozen;
    /* b_B stays the same, or is further from the onboard model than 2 uT and what its degrees leave out; the
     * model is used in its place */
    bool field_failed;
    /* T; frame B; Field that the controller uses: b_B, or that of the onboard model where b_B is not
     * connected or has failed */
    double b_used_B[3];
    /* rad/s; frame B; Estimated bias of the measured rate */
    double rate_bias_estimate_B[3];
    /* N.m; Estimated Coulomb friction of the wheel */
    double wheel_friction_estimate;
    /* 1/s; Estimated viscous friction of the wheel over the inertia of its rotor */
    double wheel_decay_estimate;
    /* N.m.s; Wheel momentum that the controller uses: h_w, or its own estimate where h_w is not connected */
    double h_w_estimate;
    /* R_NB is a matrix of zeros, since there is no attitude: only rates are damped, and attitude_error is pi
     * */
    bool no_attitude;
} ControllerPlannedOutputs;

/* An optional input is not connected where an element is this large. */
#define CONTROLLER_PLANNED_ABSENT_MIN 999000000.0

static inline bool controller_planned_has_h_w(const ControllerPlannedInputs *u)
{
    return !(fabs(u->h_w) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_b_B(const ControllerPlannedInputs *u)
{
    return !(fabs(u->b_B[0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->b_B[1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->b_B[2]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_u_applied(const ControllerPlannedInputs *u)
{
    return !(fabs(u->u_applied[0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->u_applied[1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->u_applied[2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->u_applied[3]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_R_ref(const ControllerPlannedInputs *u)
{
    return !(fabs(u->R_ref[0][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[0][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[0][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[1][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[1][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[1][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[2][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[2][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->R_ref[2][2]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_Omega_ref(const ControllerPlannedInputs *u)
{
    return !(fabs(u->Omega_ref[0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ref[1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ref[2]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_dOmega_ref(const ControllerPlannedInputs *u)
{
    return !(fabs(u->dOmega_ref[0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->dOmega_ref[1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->dOmega_ref[2]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_t_ahead(const ControllerPlannedInputs *u)
{
    return !(fabs(u->t_ahead[0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[3]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[4]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[5]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[6]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[7]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[8]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[9]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[10]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[11]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[12]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[13]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[14]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->t_ahead[15]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_turn_ahead(const ControllerPlannedInputs *u)
{
    return !(fabs(u->turn_ahead[0][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[0][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[0][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[1][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[1][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[1][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[2][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[2][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[2][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[3][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[3][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[3][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[4][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[4][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[4][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[5][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[5][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[5][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[6][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[6][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[6][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[7][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[7][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[7][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[8][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[8][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[8][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[9][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[9][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[9][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[10][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[10][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[10][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[11][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[11][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[11][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[12][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[12][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[12][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[13][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[13][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[13][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[14][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[14][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[14][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[15][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[15][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->turn_ahead[15][2]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

static inline bool controller_planned_has_Omega_ahead(const ControllerPlannedInputs *u)
{
    return !(fabs(u->Omega_ahead[0][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[0][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[0][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[1][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[1][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[1][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[2][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[2][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[2][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[3][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[3][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[3][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[4][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[4][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[4][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[5][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[5][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[5][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[6][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[6][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[6][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[7][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[7][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[7][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[8][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[8][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[8][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[9][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[9][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[9][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[10][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[10][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[10][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[11][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[11][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[11][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[12][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[12][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[12][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[13][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[13][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[13][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[14][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[14][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[14][2]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[15][0]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[15][1]) >= CONTROLLER_PLANNED_ABSENT_MIN ||
             fabs(u->Omega_ahead[15][2]) >= CONTROLLER_PLANNED_ABSENT_MIN);
}

#endif
