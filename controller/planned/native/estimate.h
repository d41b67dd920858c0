/* What the controller believes of the satellite: its motion, its properties, the field round it. */
#ifndef CONTROLLER_PLANNED_ESTIMATE_H
#define CONTROLLER_PLANNED_ESTIMATE_H

#include "state.h"

/* The satellite as it is estimated now. */
Model controller_planned_believed(const ControllerPlannedLaw *law, const ControllerPlannedState *x);

/* Where a plan from x->t on takes its environment from. */
Ahead controller_planned_ahead_of(const ControllerPlannedLaw *law, const ControllerPlannedState *x, const ControllerPlannedInputs *u);

/* The estimate after the measurement. */
Motion controller_planned_corrected(const ControllerPlannedState *x, Matrix R, Vector Omega, double l);

/* Takes the sample of the inputs at x->t: field, wheel momentum, identification and filter; x->estimate is then that of now.
 * Returns what surrounds the satellite. */
Around controller_planned_take_sample(const ControllerPlannedLaw *law, ControllerPlannedState *x, const ControllerPlannedInputs *u, bool first);

#endif
