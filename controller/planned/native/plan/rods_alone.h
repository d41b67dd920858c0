/* Planning where the wheel gives no torque: over a whole orbit, until the field has turned. Times are shares of the
 * orbit's period, whatever the satellite's size is. */
#ifndef CONTROLLER_PLANNED_RODS_ALONE_H
#define CONTROLLER_PLANNED_RODS_ALONE_H

#include "plan.h"

enum { RODS_STARTS = 16, RODS_SEARCH_SAMPLES = 160 }; /* of a search; that it is expected to take */

/* The reference of a start: the target turned by R exp(by^), which goes to zero in proportion until a time. */
typedef struct {
    Vector by;    /* rad, in the target's axes */
    double until; /* s after the plan's beginning */
    double rate;  /* rad/s, at most which the start turns to it */
    bool round;   /* the long way */
} Turn;

/* Whether a wheel of such limits is as good as none. */
bool controller_planned_is_no_wheel(double torque_max, double momentum_max, const Scales *scales);

/* Horizon and weights of a plan by rods alone; the wheel keeps its momentum. Where the plan that was costs at most
 * controller_planned_rods_cost, the angle beyond what is far costs more. */
void controller_planned_plan_by_rods(Model *model, const Plan *was);

/* A start drawn at random; `random` is the generator's state. */
Turn controller_planned_random_turn(const Model *model, uint32_t *random);

/* N m s, below which a momentum to be given is left to the plan, and beyond which it is steered again. */
double controller_planned_rods_limit(const Model *model, double l, bool steered);

/* The cost above which a plan by rods is challenged, and the time from one search to the next, s; a plan that is poor
 * is challenged at once. */
double controller_planned_rods_cost(const Model *model);
double controller_planned_rods_rest(const Model *model);
bool controller_planned_rods_are_poor(const Model *model, const Plan *plan);

#endif
