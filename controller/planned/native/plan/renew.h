/* A plan renewed, and how far it sees.
 *
 * In the hold it grows by a stage at each renewal, since what has no controls yet has to stay near, up to a quarter
 * of an orbit where that is longer than the usual horizon: the field turns with the orbit, however small the
 * satellite is. Where it would be lost it is cut, since a shorter plan holds for as long as it lasts, and grows
 * again. That of a strained hold (strained.h) grows up to an orbit, and is cut where it has no motion. */
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
