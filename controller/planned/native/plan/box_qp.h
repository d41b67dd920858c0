/* min 1/2 u.H u + g.u over a box, in four variables. */
#ifndef CONTROLLER_PLANNED_BOX_QP_H
#define CONTROLLER_PLANNED_BOX_QP_H

#include "../motion.h"
#include "work.h"

enum { QP_PASSES = 6, TRIALS = 8 }; /* of a stage's programme; of a pass */
enum { WORK_QP = QP_PASSES * (WORK_PASS + (TRIALS - 1) * WORK_TRIAL + WORK_ONE_BY_ONE) };

/* `H` symmetric and positive definite. */
typedef struct {
    const double (*H)[CONTROLS];
    const double *g, *low, *high;
} BoxQp;

/* Starts from `u`, which is moved into the box; at most `passes` projected Newton steps. `free` tells which variables
 * stand off their bounds at the end, or may leave them. Returns its work. */
/*@ requires \valid(u + (0 .. 3)) && \initialized(u + (0 .. 3)) && \valid(free + (0 .. 3));
    requires \valid_read(qp) && \initialized(qp) && \initialized(&qp->H[0 .. 3][0 .. 3]);
    requires \initialized(qp->g + (0 .. 3)) && \initialized(qp->low + (0 .. 3)) && \initialized(qp->high + (0 .. 3));
    requires 0 <= passes <= 2 * QP_PASSES;
    assigns u[0 .. 3], free[0 .. 3], \result \from u[0 .. 3], qp->H[0 .. 3][0 .. 3], qp->g[0 .. 3], qp->low[0 .. 3],
        qp->high[0 .. 3], passes;
    ensures 0 <= \result <= 2 * WORK_QP;
    ensures \initialized(u + (0 .. 3)) && \initialized(free + (0 .. 3)); */
int controller_planned_box_qp(const BoxQp *qp, int passes, double u[CONTROLS], bool free[CONTROLS]);

/* x of H x = y in the free variables, by its factors L D L'; the others are zero. `columns` right sides stand one
 * beside the other. */
/*@ requires 1 <= columns <= ERRORS && \valid(y + (0 .. 4 * columns - 1)) && \initialized(y + (0 .. 4 * columns - 1));
    requires \initialized(&H[0 .. 3][0 .. 3]) && \initialized(free + (0 .. 3));
    assigns y[0 .. 4 * columns - 1] \from y[0 .. 4 * columns - 1], H[0 .. 3][0 .. 3], free[0 .. 3], columns;
    ensures \initialized(y + (0 .. 4 * columns - 1)); */
void controller_planned_solve_free(const double (*H)[CONTROLS], const bool free[CONTROLS], int columns, double *y);

#endif
