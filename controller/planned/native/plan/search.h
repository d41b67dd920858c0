/* The search for a plan from nothing: several starts, each improved, the best kept; a few iterations in each call. */
#ifndef CONTROLLER_PLANNED_SEARCH_H
#define CONTROLLER_PLANNED_SEARCH_H

#include "ilqr.h"
#include "rods_alone.h"

enum { STARTS = 6 }; /* with a wheel */

typedef struct {
    bool active, ready;
    bool urgent;         /* a plan that reaches the target in the least time is wanted */
    int32_t start, left; /* iterations of this start */
    uint32_t random;     /* state of the generator of starts */
    Motion x;
    double t;
    Plan trial, best;
} Search;

void controller_planned_search_begin(const Motion *x, double t, bool urgent, Search *search);

/* Goes on by at most `iterations`, and by no more than the account allows. */
void controller_planned_search_on(const Model *model, const Ahead *ahead, int iterations, Search *search, Workspace *w,
                                  int32_t *work);

/* The controls nearest to a demanded torque of rods and wheel in the field B_B; returns the work. */
int controller_planned_controls_for(const Model *model, Vector tau, Vector B_B, double l, double u[CONTROLS]);

/* Controls of a cascade through the limits, to start from: turns to the target, itself turned, at no more than a
 * rate. */
void controller_planned_cascade(const Model *model, const Motion *x, const Turn *turn, Plan *plan,
                                const Stage stage[STAGES + 1], int32_t *work);

#endif
