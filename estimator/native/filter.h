/* The covariance of the error state: attitude (small turn in body axes), rate or its bias, bias of the field. */
#ifndef ESTIMATOR_FILTER_H
#define ESTIMATOR_FILTER_H

#include "vector.h"

enum { ERROR_STATES = 9, ERROR_ATTITUDE = 0, ERROR_RATE = 3, ERROR_BIAS = 6 };

/* By rows. */
typedef struct {
    double m[ERROR_STATES][ERROR_STATES];
} Covariance;

enum {
    LASTING = 24,
    LASTING_OFFSET = 0,
    LASTING_SCALE = 3,
    LASTING_GYRO = 12,
    LASTING_SUN = 15,
    LASTING_TRACKER = 18,
    LASTING_START = 21
};

/* Errors of the estimate for each error that lasts, at one standard deviation: lasting.c. */
typedef struct {
    double m[ERROR_STATES][LASTING];
} Sensitivity;

/* Process noise: variances that the errors gain in 1 s. */
typedef struct {
    double angle, bias; /* rad2, T2 */
    Matrix rate;        /* rad2/s2 */
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

/* The blocks of the transition: of the attitude's error, of the rate's error into it, of the rate's error. */
typedef struct {
    Matrix attitude, turned, rate;
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

#endif
