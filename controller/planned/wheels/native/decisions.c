/* Phases and turns: docs/how/planned-wheels.md, Decisions. */
#include "sample.h"

static const double ENTER = 0.9; /* of the momentum that the wheels hold in any direction: above, it is shed */
static const double LEAST_SHED = 0.1, ROOM = 1.15; /* of that: shed to at least, and what a turn has for rates */
static const double TURN_ANGLE = 2.2;              /* rad, of the turn that follows */
static const double SHEDDING_RODS = 1.5; /* of the mean rod's dipole: the most of three, the mean over attitudes */
static const double LOST = 2.0;          /* errors, over those whose answer is all that the wheels can give */
static const double FASTER = 1.05;       /* rates, from which on a turn goes on by new limits */
/* Of their share beside momentum that is there: four wheels are evened out late. */
static const double BESIDE = 0.85;
enum { TURN_PARTS = 16 };        /* of a turn, in which its momentum is looked at */
static const double LEAST = 0.1; /* of a turn's acceleration, where the gyroscopic torque would leave less */
static const double DISTURBANCE_GAIN = 0.1, DISTURBANCE_SHARE = 0.3; /* of (2 k)^3; of the wheels' torque */

/* (3): the rate that the wheels' momenta allow from the angle `angle` to the target about the axis: the momentum H stays
 * in N, but for a ball that it turns in meanwhile with the target, and takes its way through the body. */
static double rate_about(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis, double angle, double ball)
{
    const Vector along = apply(law->J, axis), still = s->target.Omega;
    const Vector H = add(add(s->H, law->h_target), apply_transposed(s->Q, apply(law->J, still)));
    double rate = INFINITY;
    for (int i = 0; i <= TURN_PARTS; ++i) {
        const Matrix left = rotation_exp(scale(angle * (double)i / (double)TURN_PARTS, axis));
        const Vector there = apply_transposed(left, apply(s->Q, H)); /* in the body, when so much is left */
        const Vector of_body = apply(law->J, apply_transposed(left, still));
        rate = smaller(
            rate, zonotope_beside(&s->momentum, BESIDE * law->p.momentum_share, subtract(there, of_body), ball, along));
    }
    return rate;
}

/* (4) with the limits of (3) about the axis, a unit vector. */
static SlewTurn turn_about(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis, double angle)
{
    const ControllerPlannedWheelsParameters *p = &law->p;
    const Vector along = apply(law->J, axis);
    const double least = s->most / norm(along), of_target = norm(s->target.Omega);
    const double size = norm(add(s->H, law->h_target)), of_body = law->J_bound * of_target;
    const double slow = zonotope_reach(&s->momentum, smaller(size + of_body, ENTER * s->momentum.inradius), along);
    const double turned = size * smaller(1.0, of_target * angle / slow); /* of H with the target, meanwhile */
    const double rate = larger(p->momentum_share * slow, rate_about(law, s, axis, angle, turned));
    const double fastest = smaller(rate, sqrt(angle * zonotope_reach(&s->torque, 0.0, along))) + of_target;
    const double a = p->torque_share * zonotope_reach(&s->torque, fastest * (size + of_body), along);
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

/* (7): whether momentum is shed, and along which direction. */
static bool sheds(const ControllerPlannedWheelsLaw *law, const Sample *s, const ControllerPlannedWheelsInputs *u,
                  bool on, Vector *lambda)
{
    const double H = norm(add(s->H, law->h_target));
    if (H <= (on ? LEAST_SHED : ENTER) * s->momentum.inradius) {
        return false;
    }
    const Matrix R = matrix(u->R_NB);
    if (is_zero_matrix(R)) {
        return H > 0.5 * ENTER * s->momentum.inradius;
    }
    const Vector H_N = apply(R, s->H);
    const SheddingData data = {SHEDDING_RODS * law->rods_dipole, ENTER * s->momentum.inradius,
                               ROOM * s->momentum.inradius, TURN_ANGLE * law->J_bound * 2.0 / 3.0};
    const Shedding found = shedding_of(&data, H_N, on ? *lambda : direction(norm(H_N), H_N), apply(R, vector(u->b_B)),
                                       vector(u->r_N), vector(u->v_N));
    *lambda = found.lambda;
    return H > ENTER * s->momentum.inradius || found.time > 0.0;
}

/* Whether errors are below LOST times those whose answer is all that there is. */
static bool is_answered(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector zeta, Vector omega)
{
    const double k = law->p.bandwidth;
    return norm(zeta) + norm(omega) / k <= LOST * s->most / (4.0 * law->J_bound * k * k);
}

void controller_planned_wheels_decide(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                      const ControllerPlannedWheelsInputs *u, bool first,
                                      ControllerPlannedWheelsState *x)
{
    const Vector none = {0.0, 0.0, 0.0};
    const bool follows = !first && s->target.attitude && (x->phase == WHEELS_TURN || x->phase == WHEELS_HOLD);
    if (follows) {
        const Wanted plan = controller_planned_wheels_plan_at(x, &s->target, law->p.command_period);
        const Errors e = controller_planned_wheels_errors_of(&plan, matrix(u->R_NB), vector(u->omega_B));
        if (is_answered(law, s, e.zeta, e.omega)) {
            if (x->t - x->begun >= turn_time(&x->turn)) {
                const double w = 2.0 * law->p.bandwidth, most = DISTURBANCE_SHARE * s->most;
                const Vector more = scale(DISTURBANCE_GAIN * w * w * w * law->p.command_period, apply(law->J, e.zeta));
                const Vector d = add(x->disturbance_B, more);
                x->phase = WHEELS_HOLD;
                x->disturbance_B = scale(norm(d) > most ? most / norm(d) : 1.0, d);
            } else {
                hasten_turn(law, s, x);
            }
            return;
        }
    }
    x->disturbance_B = none;
    if (sheds(law, s, u, x->phase == WHEELS_SHEDDING && !first, &x->shedding)) {
        x->phase = WHEELS_SHEDDING;
    } else if (!s->target.attitude || !is_answered(law, s, none, scale(2.0, s->rate))) {
        x->phase = WHEELS_DAMPING;
    } else {
        x->phase = WHEELS_TURN;
        begin_turn(law, s, x);
    }
}
