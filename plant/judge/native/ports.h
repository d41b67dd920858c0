/* Errors of attitude and rate from the plant's truth, to LVLH or to a given reference [4].
 * Numbers in brackets are equations of Sanyal and Lee-Ho, Attitude Tracking Control of a Small Satellite in Low
 * Earth Orbit (AIAA 2009-5902).
 * Generated from fmus/interfaces/plant_judge.toml by python -m fmus.native; do not edit. */
#ifndef PLANT_JUDGE_PORTS_H
#define PLANT_JUDGE_PORTS_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    PLANT_JUDGE_REFERENCE_LVLH = 1,
    PLANT_JUDGE_REFERENCE_INERTIAL = 2,
    PLANT_JUDGE_REFERENCE_RATE = 3
};

typedef struct {
    /* 'lvlh': R_d0 relative to LVLH, of r_N and v_N; 'inertial': R_d0 in N; 'rate': from R_d0 at t = 0 with
     * the body rate Omega_d0 [3] */
    int32_t reference;
    /* frame LVLH or N from desired body; Desired attitude: relative to LVLH for 'lvlh', in N for 'inertial',
     * in N at t = 0 for 'rate'; orthonormal to 1e-3, projected onto SO(3) */
    double R_d0[3][3];
    /* rad/s; frame desired body; Desired body rate, constant, for 'rate' [3] */
    double Omega_d0[3];
} PlantJudgeParameters;

typedef struct {
    /* frame N from B; Attitude, x_N = R_NB x_B; orthonormal to 1e-4 (single precision is sufficient) */
    double R_NB[3][3];
    /* rad/s; frame B; Body rate relative to N */
    double omega_B[3];
    /* m; frame N; Position of the centre of mass, for 'lvlh' */
    double r_N[3];
    /* m/s; frame N; Velocity of the centre of mass, for 'lvlh' */
    double v_N[3];
    /* frame N from desired body; Desired attitude, orthonormal to 1e-4; with Omega_d it takes the place of
     * the parameter reference. A matrix of zeros: no reference now; optional; 1e9 means not connected */
    double R_d[3][3];
    /* rad/s; frame desired body; Desired body rate; connect both R_d and Omega_d, or none of them; optional;
     * 1e9 means not connected */
    double Omega_d[3];
} PlantJudgeInputs;

typedef struct {
    /* rad; Principal angle |zeta| of Q = R_d^T R [4], 0 to pi */
    double attitude_error;
    /* rad/s; frame B; omega = Omega - Q^T Omega_d [4] */
    double rate_error_B[3];
    /* R_NB is a matrix of zeros, since there is no attitude yet: attitude_error is pi, rate_error_B is
     * omega_B */
    bool no_attitude;
} PlantJudgeOutputs;

/* An optional input is not connected where an element is this large. */
#define PLANT_JUDGE_ABSENT_MIN 999000000.0

static inline bool plant_judge_has_R_d(const PlantJudgeInputs *u)
{
    return !(fabs(u->R_d[0][0]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[0][1]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[0][2]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[1][0]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[1][1]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[1][2]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[2][0]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[2][1]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->R_d[2][2]) >= PLANT_JUDGE_ABSENT_MIN);
}

static inline bool plant_judge_has_Omega_d(const PlantJudgeInputs *u)
{
    return !(fabs(u->Omega_d[0]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->Omega_d[1]) >= PLANT_JUDGE_ABSENT_MIN ||
             fabs(u->Omega_d[2]) >= PLANT_JUDGE_ABSENT_MIN);
}

#endif
