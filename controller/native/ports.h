/* Almost-global attitude tracking on SO(3) with gains that follow the errors [8]-[10].
 * Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in Low
 * Earth Orbit (AIAA 2009-5902).
 * Generated from fmus/interfaces/controller.toml by python -m fmus.native; do not edit. */
#ifndef CONTROLLER_PORTS_H
#define CONTROLLER_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    CONTROLLER_PHI_LINEAR = 1,
    CONTROLLER_PHI_LOGARITHM = 2,
    CONTROLLER_PHI_SQUARE_ROOT = 3
};

enum {
    CONTROLLER_GAIN_SCHEDULE_ERROR = 1,
    CONTROLLER_GAIN_SCHEDULE_CONSTANT = 2
};

enum {
    CONTROLLER_REFERENCE_LVLH = 1,
    CONTROLLER_REFERENCE_INERTIAL = 2,
    CONTROLLER_REFERENCE_RATE = 3
};

typedef struct {
    /* kg.m2; frame B; Inertia that the law assumes; it may differ from the plant's; symmetric, positive
     * definite, with each principal moment at most the sum of the others */
    double J_B[3][3];
    /* N.m; Diagonal of K0, 0 < K0[1] < K0[2] < K0[3] [9] */
    double K0[3];
    /* N.m.s; frame B; L0, symmetric and positive definite [9] */
    double L0[3][3];
    /* Phi in [8]: x, ln(1 + x/phi_scale) phi_scale, or 2 (sqrt(1 + x/phi_scale) - 1) phi_scale; each has
     * slope 1 at 0 */
    int32_t phi;
    /* J; Value of x near which Phi departs from a straight line; not used by 'linear' */
    double phi_scale;
    /* Whether the law compensates the gravity-gradient moment of its own model, -M_g(R_d Q) [8] */
    bool compensate_gravity;
    /* m3/s2; mu of the Earth in the law's M_g (WGS 84) */
    double gravitational_parameter;
    /* 'error': k and l follow the errors [10]; 'constant': k = kappa0, l = lambda0 */
    int32_t gain_schedule;
    /* kappa0 [10] */
    double kappa0;
    /* lambda0 [10] */
    double lambda0;
    /* rad; a1 [10] */
    double a1;
    /* rad; a2 [10] */
    double a2;
    /* rad/s; c1 [10] */
    double c1;
    /* rad/s; c2 [10] */
    double c2;
    /* 'lvlh': hold R_d0 relative to LVLH, from r_N and v_N; 'inertial': hold R_d0 in N; 'rate': start at R_d0
     * and turn with the body rate Omega_d0 [3] */
    int32_t reference;
    /* frame LVLH or N from desired body; Desired attitude: relative to LVLH for 'lvlh', in N for 'inertial',
     * in N at t = 0 for 'rate'; orthonormal to 1e-3, projected onto SO(3) */
    double R_d0[3][3];
    /* rad/s; frame desired body; Desired body rate, constant, for 'rate' [3] */
    double Omega_d0[3];
} ControllerParameters;

typedef struct {
    /* frame N from B; Attitude, x_N = R_NB x_B; orthonormal to 1e-4 (single precision is sufficient) */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass */
    double v_N[3];
    /* frame N from desired body; Desired attitude, orthonormal to 1e-4; with Omega_ref and dOmega_ref it
     * takes the place of the parameter reference. A matrix of zeros: no reference now, only the rate follows
     * Omega_ref; optional; 1e9 means not connected */
    double R_ref[3][3];
    /* rad/s; frame desired body; Desired body rate [3]; connect R_ref, Omega_ref and dOmega_ref, or none of
     * them; optional; 1e9 means not connected */
    double Omega_ref[3];
    /* rad/s2; frame desired body; Time derivative of Omega_ref [3]; optional; 1e9 means not connected */
    double dOmega_ref[3];
} ControllerInputs;

typedef struct {
    /* N.m; frame B; Demanded control torque on the body [8] */
    double tau_cmd_B[3];
    /* rad; Principal angle |zeta| of Q = R_d^T R [4] */
    double attitude_error;
    /* rad/s; frame B; omega = Omega - Q^T Omega_d [4] */
    double rate_error_B[3];
    /* J; V = 1/2 omega.J omega + Phi(tr(K - K Q)) [11] */
    double lyapunov;
    /* k, scale of the attitude gain: K = k K0 [9][10] */
    double gain_k;
    /* l, scale of the rate gain: L = l L0 [9][10] */
    double gain_l;
    /* R_NB is a matrix of zeros, since there is no attitude: only rates are damped, and attitude_error is pi
     * */
    bool no_attitude;
} ControllerOutputs;

/* An optional input is not connected where an element is this large. */
#define CONTROLLER_ABSENT_MIN 999000000.0

static inline bool controller_has_R_ref(const ControllerInputs *u)
{
    return !(fabs(u->R_ref[0][0]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[0][1]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[0][2]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[1][0]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[1][1]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[1][2]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[2][0]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[2][1]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->R_ref[2][2]) >= CONTROLLER_ABSENT_MIN);
}

static inline bool controller_has_Omega_ref(const ControllerInputs *u)
{
    return !(fabs(u->Omega_ref[0]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->Omega_ref[1]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->Omega_ref[2]) >= CONTROLLER_ABSENT_MIN);
}

static inline bool controller_has_dOmega_ref(const ControllerInputs *u)
{
    return !(fabs(u->dOmega_ref[0]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->dOmega_ref[1]) >= CONTROLLER_ABSENT_MIN ||
             fabs(u->dOmega_ref[2]) >= CONTROLLER_ABSENT_MIN);
}

#endif
