#include "friction.h"

#include <math.h>
#include <string.h>

#include "vector.h"

static const double EXPECTED = 0.1;     /* of the wheel's limits: standard deviation of either torque before the flight */
static const double NOISE = 0.01;       /* of the torque's limit, of a sample */
static const double CHANGES_TIME = 1e5; /* s, in which friction may become another */
static const double SHARE_MAX = 0.5;    /* of the torque's limit: largest friction of either kind */
static const double NEAR_LIMIT = 0.99;  /* of the momentum's limit, beyond which the motor may be stopped */

void controller_planned_friction_start(const ControllerPlannedParameters *p, Friction *friction)
{
    const double torque = EXPECTED * p->wheel_torque_max, decay = torque / p->wheel_momentum_max;
    const double noise = NOISE * p->wheel_torque_max;
    memset(friction, 0, sizeof *friction);
    friction->variance = noise * noise;
    friction->torque_max = p->wheel_torque_max;
    friction->momentum_max = p->wheel_momentum_max;
    if (p->identify) {
        friction->P[0][0] = torque * torque;
        friction->P[1][1] = decay * decay;
        friction->density[0] = friction->P[0][0] / CHANGES_TIME;
        friction->density[1] = friction->P[1][1] / CHANGES_TIME;
    }
}

void controller_planned_friction_learn(double dt, double torque, double l, double l_next, Friction *friction)
{
    double side = l > 0.0 ? 1.0 : -1.0;
    if (l == 0.0 && l_next == 0.0 && fabs(torque) > friction->p[0]) {
        side = torque > 0.0 ? 1.0 : -1.0; /* it stands: friction is no less than the torque */
    } else if (!(l * l_next > 0.0 && larger(fabs(l), fabs(l_next)) < NEAR_LIMIT * friction->momentum_max)) {
        return; /* nor is it known how long friction acted to either side, or whether the wheel was at its limit */
    }
    const double row[2] = {side, 0.5 * (l + l_next)};
    double column[2], spread = friction->variance, error = torque - (l_next - l) / dt;
    for (int i = 0; i < 2; ++i) {
        friction->P[i][i] += friction->density[i] * dt;
        column[i] = friction->P[i][0] * row[0] + friction->P[i][1] * row[1];
        spread += column[i] * row[i];
        error -= friction->p[i] * row[i];
    }
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
            friction->P[i][j] -= column[i] * column[j] / spread;
        }
    }
    friction->p[0] = clip(friction->p[0] + column[0] / spread * error, 0.0, SHARE_MAX * friction->torque_max);
    friction->p[1] =
        clip(friction->p[1] + column[1] / spread * error, 0.0, SHARE_MAX * friction->torque_max / friction->momentum_max);
}

double controller_planned_friction_torque(const Friction *friction, double l, double rate, double dt)
{
    const double next = l + rate * dt;
    const double side = next > 0.0 ? 1.0 : next < 0.0 ? -1.0 : 0.0;
    return friction->p[0] * side + friction->p[1] * l;
}
