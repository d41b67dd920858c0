#include "strained.h"

#include <string.h>

/* Factors of the usual weights. */
static const double STRAINED_ANGLE_WEIGHT = 0.2;
static const double STRAINED_RATE = 30.0;  /* slow enough for stages of T that the field does not outrun the plan */
static const double STRAINED_WHEEL = 0.1;  /* all of the wheel is there to be used */
static const double STRAINED_MOTOR = 100.0; /* rods oppose what the motor gives across its axis */
static const double STRAINED_WEIGHT_FAR = 30.0; /* of the angle beyond what is far */
static const double STRAINED_NEAR_LIMIT = 0.97; /* of wheel_momentum_max */
static const double TURNED_AWAY = 0.2; /* rad, of a guess that is not believed */

void controller_planned_plan_strained(Model *model)
{
    Scales *scales = &model->scales;
    scales->weight_angle *= STRAINED_ANGLE_WEIGHT;
    scales->weight_rate *= STRAINED_RATE;
    scales->weight_wheel *= STRAINED_WHEEL;
    scales->weight_motor_control *= STRAINED_MOTOR;
    scales->weight_far = STRAINED_WEIGHT_FAR;
    scales->near_limit = STRAINED_NEAR_LIMIT * model->wheel_momentum_max;
    scales->fast_nutation = true;
}

void controller_planned_keep_motion(const Plan *plan, const Motion x[STAGES + 1], PlannedMotion *planned)
{
    double t = plan->start;
    memset(planned, 0, sizeof *planned); /* to the last byte: it is part of a saved state */
    planned->nodes = plan->stages + 1;
    for (int i = 0; i < planned->nodes; ++i) {
        planned->t[i] = t;
        planned->x[i] = x[i];
        t += i < plan->stages ? plan->h[i] : 0.0;
    }
}

/* Between two nodes of the planned. */
static Motion between(const PlannedMotion *planned, int i, double t)
{
    const Motion *a = &planned->x[i], *b = a + 1;
    const double s = clip((t - planned->t[i]) / (planned->t[i + 1] - planned->t[i]), 0.0, 1.0);
    const Vector turn = rotation_log(multiply(transposed(a->R), b->R));
    return (Motion){multiply(a->R, rotation_exp(scale(s, turn))), add(a->Omega, scale(s, subtract(b->Omega, a->Omega))),
                    a->l + s * (b->l - a->l)};
}

void controller_planned_guess(const PlannedMotion *planned, const Stage stage[STAGES + 1], Plan *plan, Motion x[STAGES + 1])
{
    double t = plan->start;
    int i = 0;
    for (int k = 0; k <= plan->stages; ++k) {
        while (i < planned->nodes - 2 && t > planned->t[i + 1]) {
            ++i;
        }
        const Target *target = &stage[k].target;
        x[k] = between(planned, i, t);
        if (t > planned->t[planned->nodes - 1] || principal_angle(multiply(transposed(target->R), x[k].R)) > TURNED_AWAY) {
            x[k].R = target->R;
            x[k].Omega = target->Omega;
            if (k < plan->stages) {
                memset(plan->u[k], 0, sizeof plan->u[k]);
            }
        }
        t += k < plan->stages ? plan->h[k] : 0.0;
    }
}
