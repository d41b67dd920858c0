/* A strained hold: the wheel cannot keep the attitude close all along the orbit, and must be loaded long before the field leaves
 * the error to it alone. The plan covers an orbit; the error is kept small by what it is at its largest, and the motion is slow.
 *
 * Controls alone do not keep a motion of an orbit near the target. So the planned motion is kept from one plan to the next, and
 * the next plan is improved from that motion (ilqr.h). */
#ifndef CONTROLLER_PLANNED_STRAINED_H
#define CONTROLLER_PLANNED_STRAINED_H

#include "plan.h"

static const double STRAINED_ORBITS_AHEAD = 1.0; /* that a strained hold's plan sees */

/* A planned motion, at the begin of each stage and at the end. */
typedef struct {
    int nodes; /* 0: there is none */
    double t[STAGES + 1];
    Motion x[STAGES + 1];
} PlannedMotion;

/* The weights of a strained hold. */
void controller_planned_plan_strained(Model *model);

/* A plan's motion, kept. */
void controller_planned_keep_motion(const Plan *plan, const Motion x[STAGES + 1], PlannedMotion *planned);

/* A guess of a plan's motion from another one's; the target, without controls, where that is over or had turned far away. */
void controller_planned_guess(const PlannedMotion *planned, const Stage stage[STAGES + 1], Plan *plan, Motion x[STAGES + 1]);

#endif
