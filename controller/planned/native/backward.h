/* Gains of all stages of a motion, from its end to its beginning. */
#ifndef CONTROLLER_PLANNED_BACKWARD_H
#define CONTROLLER_PLANNED_BACKWARD_H

#include "ilqr.h"

/* Sets w->k and w->K for the motion in w->x[at], whose stages may have gaps between them; false where the account ends before. */
bool controller_planned_backward_pass(const Model *model, const Plan *plan, Workspace *w, int at, bool gaps, int32_t *work);

#endif
