/* Improves a plan by box-constrained iterative LQR on attitude, rate and wheel momentum. */
#ifndef CONTROLLER_PLANNED_ILQR_H
#define CONTROLLER_PLANNED_ILQR_H

#include "cost.h"
#include "plan.h"

/* Of one stage: the errors after it are A errors + G controls; V is the Hessian of the cost from then on, v its gradient;
 * Q the same cost with the stage's own, Lxx the diagonal of that. */
typedef struct {
    Square A, V, VA;
    double G[ERRORS][CONTROLS], VG[ERRORS][CONTROLS];
    double v[ERRORS], Qx[ERRORS], Lxx[ERRORS];
    double Qu[CONTROLS], Quu[CONTROLS][CONTROLS], Qux[CONTROLS][ERRORS];
} BackwardPass;

/* Scratch: what it holds matters within one call only. */
typedef struct {
    BackwardPass pass;
    Stage stage[STAGES + 1]; /* the last one has the final target alone */
    Motion x[2][STAGES + 1];
    double u[2][STAGES][CONTROLS];
    double k[STAGES][CONTROLS];
    double K[STAGES][CONTROLS][ERRORS];
} Workspace;

/* Improves the plan from x by at most a number of iterations, which it returns, fewer where nothing more is gained; the
 * plan's cost is then that of its motion. w->stage must be that of the plan. */
int controller_planned_improve(const Model *model, const Motion *x, int iterations, Plan *plan, Workspace *w);

#endif
