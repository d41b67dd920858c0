/* One Kalman filter for the motion and for what is not known of the satellite: bias of the measured rate, inertia,
 * gains of the rods, disturbance torque, residual dipole. */
#ifndef CONTROLLER_PLANNED_IDENTIFICATION_H
#define CONTROLLER_PLANNED_IDENTIFICATION_H

#include "../motion.h"
#include "rods_watch.h"

static const double TRUST = 0.4; /* largest change of inertia and gains of a sound satellite, relative */

/* Places in p; the inertia as J11, J22, J33, J23, J31, J12. */
enum { BIAS = 0, INERTIA = 3, GAINS = 9, TORQUE = 12, DIPOLE = 15, UNKNOWNS = 18 };
/* The errors of the estimate: turn of the body axes, rate, then those of p. */
enum { RATE_STATE = 3, MOTION = 6, FILTER_STATES = MOTION + UNKNOWNS };

typedef struct {
    double p[UNKNOWNS];     /* rad/s, kg m2, 1, N m, A m2 */
    double start[UNKNOWNS]; /* p before the flight */
    double P[FILTER_STATES][FILTER_STATES];
    double gain[MOTION][MOTION]; /* of the last sample: correction of turn and rate by the innovations of both */
    Vector bias;                 /* of the rate, before the last sample */
    double excess[3];         /* of the variances over those given, not below 1: of attitude, of rate, of the model */
    Vector last[2];           /* innovations of attitude, rad, and rate, rad/s */
    double alike[2];          /* mean cosine between the innovation and the next, of attitude and of rate */
    double evidence;          /* that `start` predicts better than p: half the sum of the squares' differences */
    int32_t rejected;         /* samples in turn that were rejected */
    RodsWatch watch;          /* for a rod that fails */
    double spread;            /* of the gains before the flight, relative */
    double inertia_spread[6]; /* kg m2, of the inertia */
    double limit[4];     /* of the bias, rad/s; of the disturbance, N m; of the dipole, A m2; of the products, kg m2 */
    double variance[2];  /* rad2, rad2/s2, of a measurement */
    Vector sigma_B;      /* rad, of an attitude that an estimator gives */
    bool taught;         /* the rate is measured: an estimate by the equations of motion tells nothing */
    bool estimated;      /* an estimator gives attitude and rate: errors of its attitude last, and tell nothing */
    double dipole;       /* A m2, of the strongest rod at its limit */
    double rate_density; /* rad2/s3, of the model's error at rest */
    double bias_density; /* rad2/s3, of the bias's change */
    double torque_density; /* (N m)2/s, of the disturbance's change */
    double time;           /* T, s */
    double lasts, forgets; /* s, for which the model's error stays alike; of the average of innovations */
} Identification;

/* A sample of dt that has passed. */
typedef struct {
    double dt;
    const Model *model; /* as it was estimated */
    const Around *around;
    Motion before, after; /* estimated, and predicted from it */
    Vector B_B;           /* T, in the middle */
    const Vector *rods;   /* (3) A m2, body axes: what each rod was to give, at gain 1 */
} Passed;

/* What is known before the flight: the parameters, and the first measurement. */
void controller_planned_identification_start(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u,
                                             const Scales *scales, Identification *id);

/* The noise of the measurements is that of the parameters, which may change in flight; or an estimator gives attitude,
 * with these deviations, rad, and rate, without a bias. */
void controller_planned_set_noise(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u,
                                  Identification *id);

/* Whether the rate is measured. Where it no longer is, a suspicion of rods came from the gyro, and is forgotten. */
void controller_planned_set_taught(bool taught, Identification *id);

/* The bound of the disturbance, and how soon it is forgotten. */
void controller_planned_set_disturbance(const Scales *scales, bool strained, Identification *id);

/* Inertia and gains are those of before the flight again. */
void controller_planned_begin_properties(Identification *id);

/* A rod may have failed: the gains are sought in a wide range, and what else may have taken up the failure anew. */
void controller_planned_suspect_rods(Identification *id);

/* An attitude that an estimator gives is taken as it is, whether or not its rate is. */
void controller_planned_take_attitude(Identification *id);

/* Attitude and rate are those that were measured; the rate's error is then that of noise and bias. */
void controller_planned_take_measured(Identification *id);

/* The estimated inertia, or one between it and the start's where it is none of a body. */
Matrix controller_planned_estimated_inertia(const Identification *id);

/* Standard deviations of its elements, kg m2, before the flight and now. */
Matrix controller_planned_sigma_before(const ControllerPlannedParameters *p);
Matrix controller_planned_inertia_sigma(const Identification *id);

/* The mean magnitude of the rods' gains. */
double controller_planned_rods_gain(const Identification *id);

/* The rod, 1 to 3, whose gain is known to be farthest from that of before the flight, where it has failed; 0: none. */
int32_t controller_planned_failed_rod(const Identification *id);

/* Whether a rod that has failed is stuck on: the satellite's dipole is surely larger than that of a sound one. */
bool controller_planned_stuck_on(const Identification *id);

/* The covariance after the sample. */
void controller_planned_propagate(const Passed *passed, Identification *id);

/* p, P and gain after a measurement with these innovations, rad and rad/s; of an estimated attitude that of the rate
 * alone, and the attitude is then the measured one. */
void controller_planned_correct(const double innovation[MOTION], Identification *id);

/* The correction by the measurement at the sample's end. `turn`, rad, and `rate`, rad/s, are the innovations, with
 * the bias taken off; `nominal`, rad/s, is that of the rate predicted with inertia and gains as before the flight.
 * `watched`: whether failed rods are looked for. */
void controller_planned_learn(double dt, Vector turn, Vector rate, Vector nominal, bool watched, Identification *id);

#endif
