/* docs/how/planned-orbit.md, Rods alone. Tests: test_rods_alone.py. */
#include "rods_alone.h"

/* In the orbit's period. */
static const Horizon RODS_HORIZON = {{1.0 / 12.0, 1.0 / 3.0, 1.0}, {1.0 / 600.0, 1.0 / 200.0, 1.0 / 99.0}};
static const double RODS_FINAL = 0.2;       /* by which the errors at the end count */
static const double RODS_CHALLENGED = 0.05; /* cost of a plan that is challenged: some 5 deg throughout */
static const double RODS_REST =
    1.0 / 12.0;                      /* of the period: searches follow no sooner than the field turns by 30 deg */
static const double RODS_POOR = 4.0; /* times RODS_CHALLENGED: some 10 deg throughout */
static const double RODS_WEIGHT_FAR = 100.0; /* of the angle beyond what is far */
static const double TURN_UNTIL = 0.6;        /* latest end of a start's turn */
/* In the orbit's rate n. */
static const double RODS_WEIGHT_RATE = 0.36; /* 1/n^2 */
static const double RODS_WEIGHT_CONTROL = 3e-5;
static const double RODS_STEERED = 3.0;                  /* n J, momentum that is left to the plan */
static const double RODS_AGAIN = 12.0;                   /* n J, momentum from which it is steered again */
static const double TURN_SLOWEST = 1.0, TURN_MORE = 8.0; /* n, least rate of a start and range above it */
static const double TURN_LARGEST = 3.0;                  /* rad, of a start */
static const double NO_WHEEL = 0.01; /* of momentum J/T and torque J/T^2, below which a wheel is as good as none */

bool controller_planned_is_no_wheel(double torque_max, double momentum_max, const Scales *scales)
{
    return torque_max < NO_WHEEL * scales->torque || momentum_max < NO_WHEEL * scales->momentum;
}

void controller_planned_plan_by_rods(Model *model, const Plan *was)
{
    Scales *scales = &model->scales;
    const double period = scales->period, n = scales->orbit_rate;
    model->wheel_torque_max = 0.0;
    for (int i = 0; i < PIECES; ++i) {
        model->horizon.until[i] = RODS_HORIZON.until[i] * period;
        model->horizon.stage[i] = RODS_HORIZON.stage[i] * period;
    }
    scales->weight_rate = RODS_WEIGHT_RATE / (n * n);
    const bool close = was->stages > 0 && was->cost <= controller_planned_rods_cost(model);
    scales->weight_far = close ? RODS_WEIGHT_FAR : 0.0;
    scales->weight_wheel = scales->weight_near_limit = 0.0;
    const double ratio = 1.0 / (n * n * scales->time * scales->time); /* of the rods' torque J/T^2 to n^2 J */
    scales->weight_control = scales->weight_motor_control = RODS_WEIGHT_CONTROL * ratio * ratio;
    scales->final_errors = RODS_FINAL * period;
    scales->plan_period = larger(scales->plan_period, model->horizon.stage[0]);
}

/* In [0, 1): a linear congruential generator, of which the upper bits are taken (Knuth; Numerical Recipes'
 * constants). */
static double draw(uint32_t *random)
{
    *random = (*random * UINT32_C(1664525) + UINT32_C(1013904223)) & UINT32_C(0xffffffff);
    return (double)(*random >> 8) / 16777216.0;
}

Turn controller_planned_random_turn(const Model *model, uint32_t *random)
{
    const double z = 2.0 * draw(random) - 1.0, around = ONBOARD_TURN * draw(random), across = sqrt(1.0 - z * z);
    const Vector axis = {across * cos(around), across * sin(around), z};
    const double angle = TURN_LARGEST * draw(random), until = TURN_UNTIL * draw(random) * model->scales.period;
    return (Turn){scale(angle, axis), until, (TURN_SLOWEST + TURN_MORE * draw(random)) * model->scales.orbit_rate,
                  false};
}

double controller_planned_rods_limit(const Model *model, double l, bool steered)
{
    const Scales *scales = &model->scales;
    const double unit = scales->orbit_rate * scales->momentum * scales->time;
    /* While a plan turns the satellite, the wheel's momentum may stand either way to that at the target. */
    return steered ? smaller(RODS_STEERED * unit, scales->steering_limit) : RODS_AGAIN * unit + 2.0 * fabs(l);
}

double controller_planned_rods_cost(const Model *model)
{
    return RODS_CHALLENGED * model->scales.period;
}

double controller_planned_rods_rest(const Model *model)
{
    return RODS_REST * model->scales.period;
}

bool controller_planned_rods_are_poor(const Model *model, const Plan *plan)
{
    return plan->cost > RODS_POOR * controller_planned_rods_cost(model);
}
