/* Acquisition and hold within the limits of rods and wheel: the total momentum is steered first, then a receding-
 * horizon plan brings the satellite to its target, and the law [8] of Sanyal and Lee-Ho, AIAA 2009-5902, tracks the
 * plan.
 *
 * Flight code: plain functions of plain structures, no memory but `ControllerPlannedState` (and the workspace in
 * `ControllerPlannedLaw`, whose content matters within one call only), bounded time, no recursion. Use: check and
 * prepare once (and again after a change of parameters), start once, then step at every sample. SI units and
 * radians; frames as at the ports. A function that returns false has noted a fault.
 * */
#ifndef CONTROLLER_PLANNED_H
#define CONTROLLER_PLANNED_H

#include "fault.h"
#include "state.h"

#define CONTROLLER_PLANNED_GUARDED /* it gives outputs that are finite, or a fault names one that is not */

bool controller_planned_check(const ControllerPlannedParameters *p, Fault *f);

/* p must have passed the check; before the first time its workspace and steering_field are zero. */
void controller_planned_prepare(const ControllerPlannedParameters *p, ControllerPlannedLaw *law);

/* The state at t = 0, with the first steering or plan. */
bool controller_planned_start(ControllerPlannedLaw *law, const ControllerPlannedInputs *u, ControllerPlannedState *x,
                              Fault *f);

/* The law [8] at x->t on the plan that is flown, or what is held between two samples. */
bool controller_planned_outputs(const ControllerPlannedLaw *law, const ControllerPlannedState *x,
                                const ControllerPlannedInputs *u, ControllerPlannedOutputs *y, Fault *f);

/* From t to t + h: u are the inputs at t + h. */
bool controller_planned_step(ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u,
                             double h, ControllerPlannedOutputs *y, Fault *f);

#endif
