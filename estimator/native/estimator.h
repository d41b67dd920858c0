/* Attitude, rate and gyro bias by a multiplicative extended Kalman filter, from what is measured and when it is.
 *
 * Flight code: plain functions of plain structures, no memory but `EstimatorState`, bounded time, no recursion.
 * Use: check and prepare once (and again after a change of parameters), start once, then step at every sample.
 * SI units and radians; frames as at the ports. A function that returns false has noted a fault. */
#ifndef ESTIMATOR_H
#define ESTIMATOR_H

#include "state.h"

#define ESTIMATOR_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

bool estimator_check(const EstimatorParameters *p, Fault *f);

/* p must have passed the check. */
void estimator_prepare(const EstimatorParameters *p, EstimatorLaw *law);

/* The state at t = 0, at which what is measured is new. */
bool estimator_start(const EstimatorLaw *law, const EstimatorInputs *u, EstimatorState *x, Fault *f);

/* The last step again with the measurements as they stand. */
bool estimator_outputs(const EstimatorLaw *law, const EstimatorState *x, const EstimatorInputs *u, EstimatorOutputs *y,
                       Fault *f);

/* From t to t + h; u are the measurements at t + h. */
bool estimator_step(const EstimatorLaw *law, EstimatorState *x, const EstimatorInputs *u, double h, EstimatorOutputs *y,
                    Fault *f);

#endif
