/* A bank of filters, from all turns about the first field and from gyro scales; the most likely one is the estimate. */
#ifndef ESTIMATOR_BANK_H
#define ESTIMATOR_BANK_H

#include <stdint.h>

#include "filter.h"
#include "rotation.h"

/* The state has room for them whether or not `bank` is asked for. A host that never does compiles all files with
 * ESTIMATOR_WITHOUT_BANK: the state is then 50 KB smaller, and estimator_check refuses `bank`. */
#if defined(ESTIMATOR_WITHOUT_BANK)
enum { BANK_TURNS = 1, BANK_SCALES = 2 };
#else
enum { BANK_TURNS = 8, BANK_SCALES = 5 };
#endif
enum { BANK_FILTERS = BANK_TURNS * BANK_SCALES, BANK_DIODES = 6 };

enum { BANK_STATES = 12, BANK_SCALE = 9 };

/* Its error state is (turn in B, gyro bias, field bias, gyro scale): that of the one filter, and behind it the scale. */
typedef struct {
    Matrix R;
    Vector bias, field_bias, scale;
    double score; /* log-likelihood */
    double P[BANK_STATES][BANK_STATES];
} BankFilter;

typedef struct {
    int32_t count;    /* of the filters; 0 until the first field */
    int32_t taken;    /* measurements of the field since filters were last taken out */
    int32_t in_a_row; /* measurements of the field beyond the gate of the best filter, one after the other */
    Vector rate;      /* of the gyro as measured */
    Vector scale;     /* of the gyro, by the best filter */
    double ambiguity; /* rad, from the best attitude to the farthest that is not excluded */
    double strain;    /* of the best filter's bias and scale, in deviations of what was known before */
    BankFilter of[BANK_FILTERS];
} Bank;

/* Standard deviations; `angle` and the walks in 1 s. */
typedef struct {
    double angle, bias_walk, bias, scale, field_bias, field_walk;
} BankNoise;

/* Without a filter. */
void estimator_bank_clear(Bank *bank);

/* With the field (T) in B and in N. */
void estimator_bank_start(Vector b_B, Vector B_N, const BankNoise *noise, Bank *bank);

/* Over h s, by the measured rates of the last measurement and of this one, `since` s apart; 0 without a new one. */
void estimator_bank_propagate(Vector now, double h, double since, const BankNoise *noise, Bank *bank);

/* Takes a measurement unless it is beyond the gate; returns the normalised innovation squared. */
double estimator_bank_correct(const Innovation *innovation, double gate, BankFilter *filter);

/* The number of the most likely filter. */
int32_t estimator_bank_best(const Bank *bank);

/* Takes out filters that are next to impossible, and of those within 3 deg all but the better. */
void estimator_bank_prune(Bank *bank);

/* Ambiguity, strain and scale of the best filter. */
void estimator_bank_look(const BankNoise *noise, Bank *bank);

/* 1 where an attitude far from the best fits alike, 2 where the gyro's errors are not such as can be, else 0. */
int32_t estimator_bank_doubtful(const Bank *bank);

/* Rows: two axes across a direction of length 1, and that. */
Matrix estimator_axes_about(Vector z);

#endif
