/* docs/how/planned-orbit.md, Strained hold. Tests: test_strained.py. */
#include "strained.h"

#include <string.h>

/* Factors of the usual weights. */
static const double STRAINED_WEIGHT = 0.2;       /* of the angle */
static const double STRAINED_WEIGHT_RATE = 30.0; /* slow enough for stages of T and longer */
static const double STRAINED_WEIGHT_WHEEL = 0.1;
static const double STRAINED_WEIGHT_MOTOR = 100.0; /* the rods have to oppose what the motor gives across the field */
static const double STRAINED_WEIGHT_FAR = 30.0;    /* of the angle beyond what is far */
static const double STRAINED_NEAR_LIMIT = 0.97;    /* of what the wheel is let hold */
static const double TURNED_AWAY = 1.0; /* rad from the target, beyond which a kept motion is not used as a guess */

void controller_planned_plan_strained(Model *model)
{
    Scales *scales = &model->scales;
    scales->weight_angle *= STRAINED_WEIGHT;
    scales->weight_rate *= STRAINED_WEIGHT_RATE;
    scales->weight_wheel *= STRAINED_WEIGHT_WHEEL;
    scales->weight_motor_control *= STRAINED_WEIGHT_MOTOR;
    scales->weight_far = STRAINED_WEIGHT_FAR;
    scales->near_limit = STRAINED_NEAR_LIMIT * scales->wheel_momentum;
    scales->fast_nutation = true; /* in stages of T the wheel makes any satellite nutate */
}

void controller_planned_plan_gently(Model *model)
{
    model->scales.weight_rate *= STRAINED_WEIGHT_RATE;
}

void controller_planned_keep_motion(const Plan *plan, const Motion x[STAGES + 1], PlannedMotion *kept)
{
    double t = plan->start;
    memset(kept, 0, sizeof *kept); /* to the last byte: it is part of a saved state */
    kept->nodes = plan->stages + 1;
    for (int i = 0; i < kept->nodes; ++i) {
        kept->t[i] = t;
        kept->x[i] = x[i];
        t += i < plan->stages ? plan->h[i] : 0.0;
    }
}

/* Between the nodes i and i + 1. */
static Motion between(const PlannedMotion *kept, int i, double t)
{
    const Motion *a = &kept->x[i], *b = a + 1;
    const double s = clip((t - kept->t[i]) / (kept->t[i + 1] - kept->t[i]), 0.0, 1.0);
    const Vector turn = rotation_log(multiply(transposed(a->R), b->R));
    return (Motion){multiply(a->R, rotation_exp(scale(s, turn))), add(a->Omega, scale(s, subtract(b->Omega, a->Omega))),
                    a->l + s * (b->l - a->l)};
}

void controller_planned_guess(const PlannedMotion *kept, const Stage stage[STAGES + 1], Plan *plan,
                              Motion x[STAGES + 1])
{
    const int last = kept->nodes > 0 ? kept->nodes - 1 : 0;
    double t = plan->start;
    int i = 0;
    for (int k = 0; k <= plan->stages; ++k) {
        while (i < last - 1 && t > kept->t[i + 1]) {
            ++i;
        }
        const Target *target = &stage[k].target;
        x[k] = between(kept, i, t);
        if (t > kept->t[last] || principal_angle(multiply(transposed(target->R), x[k].R)) > TURNED_AWAY) {
            x[k].R = target->R;
            x[k].Omega = target->Omega;
            if (k < plan->stages) {
                memset(plan->u[k], 0, sizeof plan->u[k]);
            }
        }
        t += k < plan->stages ? plan->h[k] : 0.0;
    }
}
