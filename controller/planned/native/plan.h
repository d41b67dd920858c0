/* A plan: controls, constant over each of the stages that divide the horizon. */
#ifndef CONTROLLER_PLANNED_PLAN_H
#define CONTROLLER_PLANNED_PLAN_H

#include "motion.h"
#include "work.h"

enum { STAGES = 208 };

/* The controls u, each -1 to 1: rods over dipole_max, dl_w/dt over wheel_torque_max. */
typedef struct {
    int stages;
    double start;     /* s */
    double h[STAGES]; /* s */
    double u[STAGES][CONTROLS];
    double cost;
} Plan;

typedef struct {
    Around around; /* in the middle of the stage */
    Target target; /* at its beginning */
} Stage;

static const double NEVER = 1e300; /* cost of a motion that is no plan */

/* Whether the plan has a motion: none turns faster than its stages can follow. */
static inline bool may_be_flown(const Plan *plan)
{
    return plan->cost < NEVER;
}

/* The controls at t; zero before the plan's start and after its end. */
void controller_planned_plan_at(const Plan *plan, double t, double u[CONTROLS]);

/* What surrounds the stages that the plan has, taken from the account; the last of STAGES + 1 has the final target alone. */
void controller_planned_survey(const Ahead *ahead, const Plan *plan, Stage stage[STAGES + 1], int32_t *work);

/* The horizon of a plan with rods and wheel; T of the scales, s. */
Horizon controller_planned_horizon(double T);

/* The stages of a horizon from t on, of the plan that was (or none), finer where its motion from x turns fast; its
 * controls are carried over, zero beyond its end. */
void controller_planned_lay_stages(const Model *model, const Ahead *ahead, const Motion *x, double t, const Plan *was,
                                   Plan *plan, Stage stage[STAGES + 1], int32_t *work);

#endif
