/* Improves a plan by box-constrained iterative LQR on attitude, rate and wheel momentum. */
#ifndef CONTROLLER_PLANNED_ILQR_H
#define CONTROLLER_PLANNED_ILQR_H

#include "box_qp.h"
#include "cost.h"
#include "plan.h"

/* Of each stage of an iteration: what is left of an account has to allow it, or none is begun. It is enough nearly
 * always; where it is not the iteration is given up. */
enum { WORK_OF_ITERATION = WORK_BACKWARD + 3 * WORK_PASS + WORK_ROLLOUT };

/* Of one stage: the errors after it are A errors + G controls, both by their columns; V is the Hessian of the cost
 * from then on, v its gradient; VA by its columns; Q the same cost with the stage's own, Lxx the diagonal of that. */
typedef struct {
    Square A, V, VA;
    double G[CONTROLS][ERRORS];
    double v[ERRORS], Qx[ERRORS], Lxx[ERRORS];
    double Qu[CONTROLS], Quu[CONTROLS][CONTROLS], Qux[CONTROLS][ERRORS];
} BackwardPass;

/* Scratch: what it holds matters within one call only. */
typedef struct {
    BackwardPass pass;
    Stage stage[STAGES + 1]; /* the last one has the final target alone */
    Motion x[2][STAGES + 1];
    double weight[STAGES]; /* of the errors */
    double u[2][STAGES][CONTROLS];
    double k[STAGES][CONTROLS];
    double K[STAGES][CONTROLS][ERRORS];
    int now; /* the plan's own motion is x[now] */
} Workspace;

/* Improves the plan from x by at most a number of iterations; the plan's cost is then that of its motion. Returns
 * the iterations that it took from the account; all of them where nothing more is to be gained. w->stage must be
 * that of the plan. `expected`: where the plan's motion should have come to by now, or NULL; from x that motion is
 * followed by the gains about it, where that is better than its controls alone. */
int controller_planned_improve(const Model *model, const Motion *expected, const Motion *x, int iterations, Plan *plan,
                               Workspace *w, int32_t *work);

/* The same from a guess of the motion in w->x[0], whose stages need not join (multiple shooting): the first
 * iteration joins them, and the cost may grow by that. The controls alone would lead a long plan far away. */
void controller_planned_improve_guess(const Model *model, const Motion *x, int iterations, Plan *plan, Workspace *w,
                                      int32_t *work);

/* Sets w->k and w->K for the motion in w->x[at], whose stages may have gaps between them; false where no more than
 * `kept` of the account, for what comes after, would be left before. */
bool controller_planned_backward_pass(const Model *model, const Plan *plan, Workspace *w, int at, bool gaps,
                                      int32_t kept, int32_t *work);

#endif
