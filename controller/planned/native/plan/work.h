/* The work of planning, counted, so that a sample has no more than it may.
 *
 * The unit is 100 instructions of a Cortex-M7, compiled with -O2; each number is the most that its part takes there.
 * What is counted are stages, passes and trials, never a clock, so that the same inputs give the same plan on any
 * computer. */
#ifndef CONTROLLER_PLANNED_WORK_H
#define CONTROLLER_PLANNED_WORK_H

#include <stdint.h>

enum {
    WORK_OF_SAMPLE = 176000, /* what else a sample does takes less than 0.4 million instructions */
    WORK_STEERING = 16000,   /* the costate improved */
    /* Of a stage: */
    WORK_LAY = 120,
    WORK_GUESS = 45, /* with what its gap adds to the backward pass */
    WORK_SURVEY = 100,
    WORK_CASCADE = 30, /* without its quadratic programme */
    WORK_ROLLOUT = 21,
    WORK_BACKWARD = 80, /* without its quadratic programme */
    /* Of a quadratic programme: */
    WORK_PASS = 9, /* with one trial */
    WORK_TRIAL = 2,
    WORK_ONE_BY_ONE = 3,
    WORK_LEAST = -1000000000 /* no account is overdrawn by more, whatever is asked for */
};

/* Takes work from an account. */
static inline void spend(int32_t *account, int32_t work)
{
    *account = *account > WORK_LEAST + work ? *account - work : WORK_LEAST;
}

#endif
