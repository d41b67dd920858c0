/* The covariance of the error state: attitude (small turn in body axes), rate or its bias, bias of the field; where the
 * gyro has failed the last part is the disturbance. */
#ifndef ESTIMATOR_FILTER_H
#define ESTIMATOR_FILTER_H

#include "vector.h"

enum { ERROR_STATES = 9, ERROR_ATTITUDE = 0, ERROR_RATE = 3, ERROR_BIAS = 6 };

/* By rows. */
typedef struct {
    double m[ERROR_STATES][ERROR_STATES];
} Covariance;

enum {
    LASTING = 27,
    LASTING_OFFSET = 0,
    LASTING_SCALE = 3,
    LASTING_GYRO = 12,
    LASTING_SUN = 15,
    LASTING_TRACKER = 18,
    LASTING_START = 21,
    LASTING_DRIFT = 24 /* an offset of the field that has grown for minutes: of one that lasts the bias takes most */
};

/* Errors of the estimate for each error that lasts, at one standard deviation: lasting.c. */
typedef struct {
    double m[ERROR_STATES][LASTING];
} Sensitivity;

/* Process noise: variances that the errors gain in 1 s. Where the last part of the error state is that of a torque, it
 * pushes the rate, and `lasts` of it is left after the step. */
typedef struct {
    double angle, bias; /* rad2, T2 or (N m)2 */
    Matrix rate;        /* rad2/s2 */
    bool by_torque;
    Matrix push; /* 1/(kg m2) */
    double lasts;
} Walks;

/* A measurement against its prediction: y = H_attitude delta (+ mu where it is biased) + noise of variances r. */
typedef struct {
    Vector y;
    Matrix H_attitude;
    bool biased;
    Vector r;
    double lasting; /* deviation of errors that last, beside r: for what is averaged */
} Innovation;

/* With nothing known but standard deviations in each axis. */
void estimator_covariance_at_start(double attitude, double rate, double bias, Covariance *P);

/* The blocks of the transition: of the attitude's error, of the rate's error into it, of the rate's error; of a torque
 * into that, and what is left of it. */
typedef struct {
    Matrix attitude, turned, rate, pushed;
    double lasts;
} Transition;

/* After h s, in which the body turns by `turn`, rad: the rate's error grows by F, 1/s, and turns the attitude's with
 * `sign`: -1 for a gyro's bias, +1 for a rate. */
Transition estimator_propagate(Vector turn, double h, double sign, Matrix F, const Walks *walks, Covariance *P);

/* What a measurement gives: the error state, each component over its standard deviation with what lasts, the gains. */
typedef struct {
    double error[ERROR_STATES], scaled[3], gains[3][ERROR_STATES];
} Correction;

/* Takes a measurement, its components in turn, each in Joseph's form; returns the normalised innovation squared. */
double estimator_correct(const Innovation *innovation, Covariance *P, Correction *given);

enum { ERROR_STATES_MAX = 12 };

/* The same of a covariance of more states, whose first ones are those above: residuals and variances by component. */
typedef struct {
    double error[ERROR_STATES_MAX], residual[3], variance[3], gains[3][ERROR_STATES_MAX];
} LongCorrection;

/* P: by rows. */
/*@ requires 1 <= states <= ERROR_STATES_MAX && \valid(P + (0 .. states * states - 1)) && \valid(given);
    requires \initialized(P + (0 .. states * states - 1)) && \valid_read(innovation);
    requires \initialized(&innovation->y) && \initialized(&innovation->H_attitude) && \initialized(&innovation->r);
    requires \initialized(&innovation->biased);
    assigns P[0 .. states * states - 1], given->error[0 .. 11], given->residual[0 .. 2], given->variance[0 .. 2],
        given->gains[0 .. 2][0 .. states - 1], \result \from P[0 .. states * states - 1], *innovation, states;
    ensures \initialized(P + (0 .. states * states - 1)) && \initialized(given->error + (0 .. 11));
    ensures \initialized(given->residual + (0 .. 2)) && \initialized(given->variance + (0 .. 2));
    ensures \initialized(given->gains[0] + (0 .. states - 1)) && \initialized(given->gains[1] + (0 .. states - 1)) &&
        \initialized(given->gains[2] + (0 .. states - 1)); */
double estimator_correct_states(const Innovation *innovation, int states, double P[], LongCorrection *given);

#endif
