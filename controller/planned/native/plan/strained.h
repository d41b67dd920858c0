/* A strained hold: its plan covers an orbit, so that the wheel is loaded before the field stands across its axis, and
 * begins with the motion of the plan before (controller_planned_improve_guess). */
#ifndef CONTROLLER_PLANNED_STRAINED_H
#define CONTROLLER_PLANNED_STRAINED_H

#include "plan.h"

static const double STRAINED_ORBITS_AHEAD = 1.0; /* that a strained hold's plan sees */

/* The motion of a plan, at the beginning of each stage and at the end. */
typedef struct {
    int nodes; /* 0: there is none */
    double t[STAGES + 1];
    Motion x[STAGES + 1];
} PlannedMotion;

/* Gives the model the weights of a strained hold. */
void controller_planned_plan_strained(Model *model);

/* Gives the model the weight of rates of a satellite that its own dipole turns away, however well it is held. */
void controller_planned_plan_gently(Model *model);

/* Keeps the motion x of the plan. */
void controller_planned_keep_motion(const Plan *plan, const Motion x[STAGES + 1], PlannedMotion *kept);

/* A guess x of the plan's motion from the one that was kept; the target, without controls, where that has ended or
 * turned away. */
void controller_planned_guess(const PlannedMotion *kept, const Stage stage[STAGES + 1], Plan *plan,
                              Motion x[STAGES + 1]);

#endif
