/* A plan: controls, constant over each of the stages that divide the horizon. */
#ifndef CONTROLLER_PLANNED_PLAN_H
#define CONTROLLER_PLANNED_PLAN_H

#include "../motion.h"
#include "work.h"

enum { STAGES = 208 };

/* The controls u, each -1 to 1: rods over dipole_max, dl_w/dt over wheel_torque_max. */
typedef struct {
    int stages;
    double start;     /* s */
    double h[STAGES]; /* s */
    double u[STAGES][CONTROLS];
    double cost;
    bool urgent;    /* the target is to be reached in the least time */
    double until;   /* s, before which errors cost little: the target is to be reached by then */
    double settles; /* s, from when on the motion stays near the target to the plan's end; infinite where it does not */
    double caution; /* 1/s, that a change of the controls costs in an iteration */
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

/* Whether a plan is better than another from about the time t on. An urgent one is where it reaches the target in
 * less than a share of the other's time; each is at less than that share of the cost, an urgent one in no more time. */
bool controller_planned_better(const Plan *plan, const Plan *other, double t, double share);

/* Asks for the target sooner than the plan reaches it. */
void controller_planned_hasten(Plan *plan);

/* The controls at t; zero before the plan's start and after its end. */
void controller_planned_plan_at(const Plan *plan, double t, double u[CONTROLS]);

/* What surrounds the stages that the plan has, taken from the account; the last of STAGES + 1 has the final target
 * alone. */
void controller_planned_survey(const Ahead *ahead, const Plan *plan, Stage stage[STAGES + 1], int32_t *work);

/* The horizon of a plan with rods and wheel; T of the scales, s. */
Horizon controller_planned_horizon(double T);

/* The stages of a horizon from t on, of the plan that was (or none), finer where its motion from x turns fast; its
 * controls are carried over, zero beyond its end. An urgent plan has a short horizon: the motion far ahead, which
 * has not been planned yet, would outweigh all; at the target the horizon is long, to foresee polar passages.
 * Without a motion (x NULL) no stage is divided. */
void controller_planned_lay_stages(const Model *model, const Ahead *ahead, const Motion *x, double t, bool urgent,
                                   const Plan *was, Plan *plan, Stage stage[STAGES + 1], int32_t *work);

#endif
