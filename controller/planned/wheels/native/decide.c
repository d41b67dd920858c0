/* Phases and turns: docs/how/planned-wheels.md, Decisions. */
#include "sample.h"

static const double ENTER = 0.95, LEAVE = 0.5; /* of the momentum that the wheels hold in any direction: shedding */
static const double SHED = 0.4;                /* of that: what shedding aims at */
static const double LOST = 2.0;                /* errors, over those whose answer is all that the wheels can give */
static const double FASTER = 1.05;             /* rates, from which on a turn goes on by new limits */
static const double LEAST = 0.1; /* of a turn's acceleration, where the gyroscopic torque would leave less */
static const double DISTURBANCE_GAIN = 0.1, DISTURBANCE_SHARE = 0.3; /* of (2 k)^3; of the wheels' torque */
static const double RODS_SLOW = 0.2; /* of the torque of a reduced set, which its turns take */

/* (4) with the limits of (3) about the axis, a unit vector. */
static SlewTurn turn_about(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis, double angle)
{
    const ControllerPlannedWheelsParameters *p = &law->p;
    const Vector along = apply(law->J, axis);
    const double least = s->most / norm(along), of_target = norm(s->target.Omega);
    if (s->reduced) {
        return (SlewTurn){angle, RODS_SLOW * least, sqrt(RODS_SLOW * least)};
    }
    const double ball = norm(add(s->H, law->h_target)) + law->J_bound * of_target;
    const double room = smaller(ball, ENTER * s->momentum.inradius);
    const double rate = p->momentum_share * zonotope_reach(&s->momentum, room, along);
    const double fastest = smaller(rate, sqrt(angle * zonotope_reach(&s->torque, 0.0, along))) + of_target;
    const double a = p->torque_share * zonotope_reach(&s->torque, fastest * ball, along);
    return (SlewTurn){angle, larger(LEAST * least, a), rate};
}

/* From rest, about the axis of the error. */
static void begin_turn(const ControllerPlannedWheelsLaw *law, const Sample *s, ControllerPlannedWheelsState *x)
{
    x->begun = x->t;
    x->axis = s->angle > 0.0 ? scale(1.0 / s->angle, s->zeta) : (Vector){1.0, 0.0, 0.0};
    x->turn = turn_about(law, s, x->axis, s->angle);
}

/* The turn goes on faster where it coasts and the wheels have been unloaded: as one from rest that began earlier. */
static void hasten_turn(const ControllerPlannedWheelsLaw *law, const Sample *s, ControllerPlannedWheelsState *x)
{
    const double time = x->t - x->begun, rise = turn_rise(&x->turn);
    if (time < rise || turn_time(&x->turn) - time < rise) {
        return;
    }
    const TurnPoint now = turn_at(&x->turn, time);
    SlewTurn turn = turn_about(law, s, x->axis, now.left);
    if (turn.rate > -FASTER * now.rate) {
        turn.angle += 0.5 * now.rate * now.rate / turn.acceleration;
        x->begun = x->t + now.rate / turn.acceleration;
        x->turn = turn;
    }
}

void controller_planned_wheels_decide(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                      const ControllerPlannedWheelsInputs *u, bool first,
                                      ControllerPlannedWheelsState *x)
{
    const double answered = LOST * s->most / (law->J_bound * 4.0 * s->k * s->k); /* rad */
    const Vector none = {0.0, 0.0, 0.0};
    const bool follows = !first && s->target.attitude && (x->phase == WHEELS_TURN || x->phase == WHEELS_HOLD);
    if (follows) {
        const Target plan = controller_planned_wheels_plan_at(x, &s->target, law->p.command_period);
        const Errors e = controller_planned_wheels_errors_of(&plan, matrix(u->R_NB), vector(u->omega_B));
        if (norm(e.zeta) + norm(e.omega) / s->k <= answered) {
            if (x->t - x->begun >= turn_time(&x->turn)) {
                const double w = 2.0 * s->k, most = DISTURBANCE_SHARE * s->most;
                const Vector more = scale(DISTURBANCE_GAIN * w * w * w * law->p.command_period, apply(law->J, e.zeta));
                const Vector d = s->reduced ? none : add(x->disturbance_B, more);
                x->phase = WHEELS_HOLD;
                x->disturbance_B = scale(norm(d) > most ? most / norm(d) : 1.0, d);
            } else {
                hasten_turn(law, s, x);
            }
            return;
        }
    }
    x->disturbance_B = none;
    const bool on = x->phase == WHEELS_SHEDDING && !first;
    if (norm(add(s->H, law->h_target)) > (on ? LEAVE : ENTER) * s->held) {
        const Matrix R = matrix(u->R_NB);
        const Vector H_N = apply(R, s->H);
        const double excess = larger(1.0 - SHED * s->held / norm(s->H), 0.0);
        x->shedding = shedding_direction(scale(excess, H_N), on ? x->shedding : direction(1.0, H_N), law->rods_dipole,
                                         vector(u->r_N), vector(u->v_N));
        x->phase = WHEELS_SHEDDING;
    } else if (!s->target.attitude || norm(s->rate) > 0.5 * answered * s->k) {
        x->phase = WHEELS_DAMPING;
    } else {
        x->phase = WHEELS_TURN;
        begin_turn(law, s, x);
    }
}
