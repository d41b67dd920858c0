/* The phases of a flight and what leads from one to another: docs/how/planned.md, Phases. */
#ifndef CONTROLLER_PLANNED_PHASES_H
#define CONTROLLER_PLANNED_PHASES_H

#include "../state.h"

/* Where the satellite stands against its target. */
typedef struct {
    Target target;
    double angle, rate; /* rad, rad/s */
    Vector D_N;         /* momentum to be given, N m s */
    bool lost;          /* too far for a plan: the momentum has to be steered first */
    bool near;          /* not lost at the end of a search that begins now */
    bool loaded;        /* the wheel holds much of its limit, or the angle is not small */
} Standing;

/* What a sample tells of the phase; several may come together. */
typedef enum {
    EVENT_NO_ATTITUDE = 1,
    EVENT_NO_TARGET = 2,
    EVENT_WHEEL = 4, /* what was planned with the wheel is no plan any more */
    EVENT_TARGET = 8,
    EVENT_LOST = 16,
    EVENT_PLAN = 32, /* there is one for now */
    EVENT_TURNED_AWAY = 64,
    EVENT_SETTLED = 128
} Event;

/* Whether the attitude is doubted, x->doubted: whether the field is not measured; `bound`, rad, on the attitude's error;
 * the rates of the satellite and of its target, rad/s. */
void controller_planned_doubt(ControllerPlannedState *x, bool field_lost, double bound, double rate, double wanted);

/* `search_time`, s, is how long a search takes. */
Standing controller_planned_standing(const ControllerPlannedState *x, const Model *model, const Ahead *ahead,
                                     const Motion *now, double search_time);

/* The events of the standing; notes since when it is that of a satellite that has settled, and of a hold that is
 * loaded. A time is reached `early`, s, before it. */
unsigned controller_planned_events(ControllerPlannedState *x, const Standing *s, double early);

/* Takes the first transition that one of the events brings; `now` is the reference of rates that are damped. Returns
 * whether a plan or a steering is due at once. */
bool controller_planned_change_phase(ControllerPlannedState *x, unsigned events, const Motion *now);

/* Whether the hold is strained from now on (plan/strained.h). */
void controller_planned_update_strain(ControllerPlannedState *x, const Standing *s);

/* Whether the search has a plan, and the time from which it plans has come. */
bool controller_planned_plan_has_come(const ControllerPlannedState *x, double early);

#endif
