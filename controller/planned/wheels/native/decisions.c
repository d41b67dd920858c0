/* Phases: docs/how/planned-wheels.md, Decisions. */
#include "sample.h"

static const double LEAST_SHED = 0.1;  /* of the inradius: shed to at least */
static const double SHED_AGAIN = 1.35; /* of the inradius: above, it is shed after damping has begun */
static const double TURN_ANGLE = 2.2;  /* rad, of the turn that follows */
static const double AIMED_ANGLE = 0.7; /* where the end of shedding is aimed at */
static const double LOST = 2.0;        /* errors, over those whose answer is all that the wheels can give */
static const double FASTER = 1.05;     /* rates, from which on a turn goes on by new limits */
static const double DISTURBANCE_GAIN = 0.1, DISTURBANCE_SHARE = 0.3; /* of (2 k)^3; of the wheels' torque */

/* The turn goes on faster where it coasts and the wheels have been unloaded: as one from rest that began earlier. */
static void hasten_turn(const ControllerPlannedWheelsLaw *law, const Sample *s, ControllerPlannedWheelsState *x)
{
    const double time = x->t - x->begun, rise = turn_rise(&x->turn);
    if (time < rise || turn_time(&x->turn) - time < rise) {
        return;
    }
    const TurnPoint now = turn_at(&x->turn, time);
    SlewTurn turn = controller_planned_wheels_turn_about(law, s, x->axis, now.left).turn;
    if (turn.rate > -FASTER * now.rate) {
        turn.angle += 0.5 * now.rate * now.rate / turn.acceleration;
        x->begun = x->t + now.rate / turn.acceleration;
        x->turn = turn;
    }
}

/* (7): whether momentum is shed, and along which direction; `turn`: time of a turn that begins now, s. */
static bool sheds(const ControllerPlannedWheelsLaw *law, const Sample *s, const ControllerPlannedWheelsInputs *u,
                  double above, double turn, ControllerPlannedWheelsState *x)
{
    const double H = norm(add(s->H, law->h_target));
    x->aim.whole = INFINITY;
    if (H <= above * s->momentum.inradius) {
        return false;
    }
    const Matrix R = matrix(u->R_NB);
    if (is_zero_matrix(R)) {
        return H > 0.5 * SHED_ABOVE * s->momentum.inradius;
    }
    const Vector H_N = apply(R, s->H);
    const bool on = above < SHED_ABOVE;
    const bool aimed = s->target.attitude && !(on && x->aim.given_up);
    const double angle = aimed ? AIMED_ANGLE : TURN_ANGLE;
    const Vector lambda = on ? x->shedding : direction(norm(H_N), H_N);
    const double held = (aimed ? SHED_TO : SHED_ABOVE) * s->momentum.inradius;
    const SheddingData data = {SHEDDING_RODS * law->rods_dipole, held, ROOM * s->momentum.inradius,
                               angle * law->J_bound * 2.0 / 3.0};
    const FieldAhead field = field_ahead(apply(R, s->b), vector(u->r_N), vector(u->v_N));
    const Shedding found = shedding_of(&data, H_N, lambda, &field);
    x->shedding = found.lambda;
    const bool waits = aimed && controller_planned_wheels_aim(law, s, u, &field, &found, turn, !on, x);
    if (x->aim.whole < INFINITY) {
        return waits && !(turn < x->aim.whole);
    }
    return !(turn < found.whole) && (H > SHED_ABOVE * s->momentum.inradius || found.time > 0.0);
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
    TurnWay way = {.time = INFINITY};
    const bool sheds_on = !first && x->phase == WHEELS_SHEDDING, damps_on = !first && x->phase == WHEELS_DAMPING;
    if (s->target.attitude) {
        way = controller_planned_wheels_best_way(law, s, damps_on, x->axis);
    }
    const double above = sheds_on ? LEAST_SHED : damps_on ? SHED_AGAIN : SHED_ABOVE;
    if (sheds(law, s, u, above, way.time, x)) {
        x->phase = WHEELS_SHEDDING;
        return;
    }
    x->phase = WHEELS_DAMPING;
    if (s->target.attitude) {
        x->phase = is_answered(law, s, none, scale(2.0, way.across)) ? WHEELS_TURN : WHEELS_DAMPING;
        x->axis = way.axis;
        x->turn = way.turn;
        x->begun = x->t - way.rate / way.turn.acceleration;
    }
}
