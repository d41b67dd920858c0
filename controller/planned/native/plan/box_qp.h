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
int controller_planned_box_qp(const BoxQp *qp, int passes, double u[CONTROLS], bool free[CONTROLS]);

/* x of H x = y in the free variables, by its factors L D L'; the others are zero. `columns` right sides stand one
 * beside the other. */
void controller_planned_solve_free(const double (*H)[CONTROLS], const bool free[CONTROLS], int columns, double *y);

#endif
