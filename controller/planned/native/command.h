/* The outputs: the law [8] on the plan, or the steering. */
#ifndef CONTROLLER_PLANNED_COMMAND_H
#define CONTROLLER_PLANNED_COMMAND_H

#include "state.h"

/* All outputs of the inputs as they stand and the motion `now`, on what was decided at the sample x->t; `controls` are those of
 * the feed-forward. */
void controller_planned_command(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const ControllerPlannedInputs *u, const Motion *now,
             double controls[CONTROLS], ControllerPlannedOutputs *y);

#endif
