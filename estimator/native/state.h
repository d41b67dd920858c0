/* The estimator's state, and the constants that follow from its parameters. */
#ifndef ESTIMATOR_STATE_H
#define ESTIMATOR_STATE_H

#include "bank.h"
#include "filter.h"
#include "fault.h"
#include "health.h"
#include "onboard_field.h"
#include "estimator_ports.h"
#include "rotation.h"

#include <stddef.h>

enum { GATED_FIELD, GATED_SUN, GATED_TRACKER, GATED };

enum { IN_A_ROW = 50 }; /* measurements of one sensor above the gate, one after the other, that are a failure */

/* The measurements that are new at the end of a step. */
typedef struct {
    bool rate, field, orbit, attitude, sun;
} Fresh;

/* The actuators over a step. */
typedef struct {
    Vector dipole;                     /* along the rods, A m2 */
    Vector wheel_torque_B, momentum_B; /* of all wheels, N m, N m s; the latter at its end */
    bool has_wheel_torque, has_h_w;
} Given;

/* dl/dt, N m, over h s. */
static inline Vector changed(Vector now, Vector before, double h)
{
    return (Vector){(now.x - before.x) / h, (now.y - before.y) / h, (now.z - before.z) / h};
}

/* All that the estimator knows at t, s. */
typedef struct {
    double t;
    bool known;    /* there is an attitude */
    bool tracking; /* the filter runs: its covariance is that of the attitude */
    bool oriented; /* there is an orbit */
    bool by_gyro;  /* the rate is the gyro's, not that of the equations of motion */
    Matrix R;
    Vector rate; /* of the gyro as measured, or, without one, the estimated rate */
    Vector rate_bias, field_bias;
    Covariance P;
    Sensitivity S;     /* what errors that last make of the estimate, beside P */
    double since_rate; /* s since the gyro's last measurement */
    Vector r_N, v_N;
    double since_orbit; /* s since the last measured orbit */
    Vector momentum_B;  /* of all wheels, N m s */
    Vector b_B;
    double b_age; /* s since it was measured */
    /* An earlier field, for a start without the Sun: as measured, turned on with the body; by the model; its age, s. */
    bool anchored;
    Vector anchor_B, anchor_N;
    double anchor_age;
    Vector disturbance_B; /* N m; of the satellite where the gyro has failed */
    double nis[GATED];
    int32_t rejected[GATED], in_a_row[GATED];
    Watch watch[SENSORS];
    /* Sensors against each other, whatever the attitude; averages in deviations: the field's strength, and its angle to
     * the Sun; field and Sun against the star tracker. */
    double field_alone[3], field_by_tracker[3], sun_by_tracker[3];
    double field_calm; /* s for which the first has been small */
    bool restarted;
    double since_start;      /* s */
    Vector fix_r_N, fix_v_N; /* the last measured orbit, whether or not it was used */
    double since_fix;
    int32_t fixes; /* in turn that agree with each other, where they do not with the orbit */
} Estimate;

/* The estimate before the last step and after it; of that step its length, s, and what counts at a step only. */
typedef struct {
    Estimate before, now;
    double h;
    int32_t counts[5];
    Fresh fresh;
    Given given;
    Bank bank; /* at the end: without `bank` it takes no time to copy a state */
} EstimatorState;

/* The bytes of a state that are in use. */
#define ESTIMATOR_STATE_USED(x) (offsetof(EstimatorState, bank.of) + (size_t)(x)->bank.count * sizeof(BankFilter))

typedef struct {
    EstimatorParameters p;
    OnboardField field;
    double days; /* of the epoch from 2000-01-01T12:00 */
    Matrix J, J_inverse, rod_axes, rod_field;
    Vector wheel_axes[ESTIMATOR_WHEELS]; /* zeros of one that is not there */
    Matrix tracker_axes;                 /* rows: two across the boresight, and that */
} EstimatorLaw;

/* The measurements that are usable. */
typedef struct {
    bool has_tracker, has_sun, has_field;
    Matrix R_NB;
    Vector sun_B, sun_N, b_B, field_N;
    double field_variance;
} Directions;

/* Of field, Sun and star tracker. */
extern const int estimator_sensor_of[GATED];

/* The orbit h s later, with what is measured then where that is of one orbit. */
void estimator_take_orbit(const EstimatorLaw *law, const EstimatorInputs *u, bool fresh, double h, Estimate *x);

/* The bias of a gyro follows its jump at a new measurement, rad/s, after a step of h s; of a magnetometer likewise,
 * where x->b_B is that of its last one, `age` s ago before this step; and neither where it has jumped to where it is
 * frozen. */
void estimator_follow_rate(const EstimatorLaw *law, const Given *given, Vector measured, double h, Estimate *x);
void estimator_follow_field(const Directions *seen, double age, Estimate *x);
void estimator_undo_jumps(Estimate *x);

/* Averages what the sensors say of each other. */
void estimator_compare(const EstimatorLaw *law, const Directions *seen, Estimate *x);

/* Whether other sensors agree with one, whatever the filter says. None does with the Sun sensors. */
bool estimator_is_backed(int gated, const Estimate *x);

/* The filter starts again: the last resort. Where it has done so just before, its gyro is wrong. */
void estimator_restart(Estimate *x);

/* A gated sensor is to be left out. What an offset of a magnetometer may have made of the estimate meanwhile, whose noise
 * has so large a variance, T2, is added to the covariance. */
void estimator_suspect(const EstimatorLaw *law, int gated, double variance, Estimate *x);

/* s for which the disturbance stays alike: an orbit. */
static const double ESTIMATOR_LASTS = 6000.0;

/* Whether the filter goes without its gyro. It then estimates a disturbance in the place of the field's bias. */
bool estimator_gyro_lost(const EstimatorLaw *law, const Estimate *x);

/* Without gyro and attitude the rate goes on by wheels, of momentum_B at first, and rods in the last field. */
void estimator_go_on_turning(const EstimatorLaw *law, const Given *given, Vector wheel_B, Vector momentum_B, double h,
                             Estimate *x);

/* N m, of that disturbance: the momentum's random walk over a radian of the orbit, by that time. */
double estimator_disturbance_sigma(const EstimatorLaw *law);

/* Weighs the gyro against the equations of motion by which the filter goes without it. */
void estimator_weigh_gyro(const EstimatorLaw *law, Vector measured, Estimate *x);

/* Goes on by the equations of motion where the gyro is not to be trusted, and by the gyro where it is again. */
void estimator_choose_rate(const EstimatorLaw *law, Estimate *x);

/* The covariance, and what errors that last make of the estimate, h s later: estimator_propagate. */
void estimator_spread(const EstimatorLaw *law, Vector turn, double sign, Matrix F, Matrix walk, double angle_variance,
                      double h, Estimate *x);

/* Errors that last: of a first attitude that they turn by `off` rad about each axis, after a measurement that was
 * used, and where the gyro is left out or used again. */
void estimator_lasting_begin(double off, Estimate *x);
void estimator_lasting_take(const EstimatorLaw *law, int gated, const Innovation *innovation,
                            const double gains[3][ERROR_STATES], Estimate *x);
void estimator_lasting_rate(double sign, Estimate *x);

/* rad: the attitude's error is below it with 99%. */
double estimator_bound(const EstimatorLaw *law, const Estimate *x, bool doubtful);

/* The first attitude, where there is one: of the star tracker, or by TRIAD (Black, 1964) of Sun and field, or of the
 * field and an earlier one. What is measured now is taken once more, by the filter, so it counts little here. */
void estimator_begin(const EstimatorLaw *law, const Directions *seen, Estimate *x);

/* Takes star tracker, Sun and field, each unless it is beyond the gate. */
void estimator_take(const EstimatorLaw *law, const Directions *seen, Estimate *x);

/* What is measured against what is predicted for an attitude and a bias of the field. */
Innovation estimator_innovation(const EstimatorLaw *law, const Directions *seen, int sensor, Matrix R,
                                Vector field_bias);

/* The estimate of the bank's best filter, h s later. Its attitude is given from the instant on at which no other one
 * fits alike. */
void estimator_by_bank(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Directions *seen,
                       double h, Estimate *x, Bank *bank);

/* Before the first measurement, with the rate that the gyro's port holds. */
void estimator_blank(const EstimatorLaw *law, const EstimatorInputs *u, Estimate *x);

/* The estimate h s later (0 at the start), with what is new then; by the bank where the parameter `bank` is true, else
 * `bank` may be NULL. */
void estimator_advance(const EstimatorLaw *law, const EstimatorInputs *u, const Fresh *fresh, const Given *given,
                       double h, Estimate *x, Bank *bank);

#endif
