/* Acquisition and hold within the actuators' limits: momentum steering, receding-horizon plan, law [8] on the plan.
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
    /* kg.m2; frame B; Inertia that the controller starts from; symmetric, positive definite, of a real body
     * */
    double J_B[3][3];
    /* N.m; Diagonal of K, 0 < K0[1] < K0[2] < K0[3] [9] */
    double K0[3];
    /* N.m.s; frame B; L, symmetric and positive definite [9] */
    double L0[3][3];
    /* s; Time between two samples of the control; between them all outputs are held */
    double control_period;
    /* frame B; Rows: the rods' unit axes u1, u2, u3 that the plan assumes [16]; unit to 1e-6, linearly
     * independent */
    double rod_axes[3][3];
    /* A.m2; Largest dipole of each rod */
    double dipole_max;
    /* N.m; Largest torque of the wheel's motor */
    double wheel_torque_max;
    /* N.m.s; Largest |h_w| that the wheel can hold */
    double wheel_momentum_max;
    /* s; Time between two plans */
    double plan_period;
    /* Iterations in one sample of the search for a plan from nothing, of 180 in all: fewer make a call
     * shorter and the search take more samples */
    int32_t search_iterations;
    /* N.m.s; Handover from steering to the plan below this distance from the target's momentum */
    double steering_limit;
    /* rad; Standard deviation of the measured attitude about each axis, as the estimator assumes it */
    double attitude_noise;
    /* rad/s; Standard deviation of the measured rate in each axis, as the estimator assumes it */
    double rate_noise;
    /* s; Time over which the estimate of the disturbance forgets */
    double disturbance_time;
    /* N.m; Largest disturbance torque that is believed */
    double disturbance_max;
    /* A.m2; Largest dipole of the satellite itself that is believed */
    double residual_dipole_max;
    /* Whether inertia and rod gain are identified in flight */
    bool identify;
    /* Standard deviation of the inertias and the rod gain before the flight, relative */
    double identify_spread;
    /* m3/s2; mu of the Earth (WGS 84) */
    double gravitational_parameter;
    /* UTC at t = 0, ISO 8601, with the time of day; ends in Z, +00:00, -00:00 or nothing */
    char epoch[64];
    /* Onboard model of the geomagnetic field, at the year of epoch */
    int32_t field_model;
    /* Degree to which the onboard field is evaluated; 1 is a tilted dipole */
    int32_t field_degree;
    /* T; Added to g10, g11, h11 of the onboard field, to make it wrong on purpose */
    double field_error[3];
    /* 'lvlh': hold LVLH, from r_N and v_N; 'inertial': hold R_d0; 'rate' is the paper's controller's and
     * refused here */
    int32_t reference;
    /* frame N from desired body; Desired attitude for 'inertial'; orthonormal to 1e-3, projected onto SO(3)
     * */
    double R_d0[3][3];
} ControllerPlannedParameters;

typedef struct {
    /* frame N from B; Attitude, x_N = R_NB x_B; orthonormal to 1e-4, so a single-precision plant will do */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass */
    double v_N[3];
    /* N.m.s; Wheel momentum l_w, strongly advised; without it the controller reckons it from its own
     * commands; optional; 1e9 means not connected */
    double h_w;
    /* T; frame B; Measured geomagnetic field; corrects the onboard field model, which is used alone without
     * it; optional; 1e9 means not connected */
    double b_B[3];
    /* A.m2, A.m2, A.m2, N.m; What rods (along their axes) and wheel (dl_w/dt) were commanded over the last
     * sample of the control, its mean where the allocator acts oftener; for the estimates, which without it
     * take what the controller asked for; optional; 1e9 means not connected */
    double u_applied[4];
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
    /* rad/s; frame B; Body rate less that of the target (not the plan) */
    double rate_error_B[3];
    /* J; V = 1/2 omega.J omega + tr(K - K Q) of the errors from the plan [11] */
    double lyapunov;
    /* k, the attitude gain's scale: constantly 1 */
    double gain_k;
    /* l, the rate gain's scale: constantly 1 */
    double gain_l;
    /* frame N from desired body; Attitude of the plan */
    double R_d[3][3];
    /* rad/s; frame desired body; Body rate of the plan */
    double Omega_d[3];
    /* rad/s2; frame desired body; Its derivative */
    double dOmega_d[3];
    /* N.m.s; Wheel momentum of the plan */
    double h_w_ref;
    /* Cost of the plan that is flown; zero while steering, -1 where the satellite turns too fast for a plan
     * */
    double plan_cost;
    /* 1: steering of the total momentum; 2: acquisition by plan; 3: hold */
    int32_t phase;
    /* N.m; frame B; Estimated disturbance torque */
    double disturbance_B[3];
    /* A.m2; frame B; Estimated dipole of the satellite itself */
    double residual_dipole_estimate_B[3];
    /* kg.m2; frame B; Estimated inertia, as the plan uses it */
    double J_estimate_B[3][3];
    /* Estimated share of a commanded dipole that the rods give */
    double rod_gain_estimate;
    /* N.m.s; Wheel momentum that the controller reckons with: h_w, or its own account where h_w is not
     * connected */
    double h_w_estimate;
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

#endif
