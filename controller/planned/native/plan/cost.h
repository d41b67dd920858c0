/* What a plan costs: errors of the motion from the target, the wheel's momentum, the controls. */
#ifndef CONTROLLER_PLANNED_COST_H
#define CONTROLLER_PLANNED_COST_H

#include "../motion.h"

/* Gradient and diagonal of the (Gauss-Newton) Hessian of a motion's cost rate, where `gradient` is not NULL; returns
 * the cost rate, 1/s. The errors' part and the wheel's are scaled by two factors. `near`, where it is not NULL:
 * whether the errors are those of a satellite that has settled. */
double controller_planned_cost_of(const Model *model, const Target *target, const Motion *x, double scale_errors,
                                  double scale_wheel, double gradient[ERRORS], double hessian[ERRORS], bool *near);

/* Cost rate of the controls. */
static inline double control_cost(const Model *model, const double u[CONTROLS])
{
    const double rods = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
    return model->scales.weight_control * rods + model->scales.weight_motor_control * u[3] * u[3];
}

#endif
