/* A plan renewed, and how far it sees: in the hold it grows, and is cut where it would be lost. */
#ifndef CONTROLLER_PLANNED_RENEW_H
#define CONTROLLER_PLANNED_RENEW_H

#include "../state.h"

static const double HOLD_COST = 2.0; /* T, of a hold's plan that has a turn in it: it is lost */

/* Whether a plan is to reach the target in the least time: with a wheel, until the hold. */
static inline bool controller_planned_is_urgent(const ControllerPlannedState *x, const Model *model)
{
    return has_wheel(model) && x->phase != PHASE_HOLD;
}

/* law->trial: the plan that was, from x->t and `now` on, as far as x->longer then says; its motion should have come
 * to `expected`. False where it would be lost and the account may not last for a shorter one: then the plan that was
 * goes on, and the next is shorter. */
bool controller_planned_renew(ControllerPlannedLaw *law, ControllerPlannedState *x, const Model *usual,
                              const Ahead *ahead, const Motion *expected, const Motion *now, const Plan *was,
                              int32_t *work);

#endif
