/* Steering, acquisition or hold, and the plan that is flown. */
#ifndef CONTROLLER_PLANNED_DECIDE_H
#define CONTROLLER_PLANNED_DECIDE_H

#include "state.h"

/* The sample's decision, on the motion `now`, dt after the last. At the first sample there is no time to keep, and no motion to
 * go on with: the search is made whole. */
void controller_planned_decide(ControllerPlannedLaw *law, ControllerPlannedState *x, const Ahead *ahead, const Motion *now, double dt, bool first);

#endif
