/* Turns from here, and the one that is soonest over: docs/how/planned-wheels.md, Turn. */
#include <string.h>

#include "reference.h"
#include "sample.h"

static const double BESIDE = 0.85;  /* of their share of the momenta: four wheels are evened out late */
static const double SURE = 0.7;     /* of what the rods shed meanwhile */
static const double SLOWEST = 0.05; /* of the rate without momentum: a slower turn is not begun */
static const double LEAST = 0.1;    /* of a turn's acceleration, where the gyroscopic torque would leave less */
static const double STAYS = 1.2;    /* times: before a turn the way is changed for one that is over so much sooner */
enum { PARTS = 16, PASSES = 3, TORQUE_PASSES = 5 }; /* of a turn, in which it is looked at; iterations */

/* Along a turn, from its end: the momentum of all, the wheels' at the target's rate, and that rate, in body axes. */
typedef struct {
    Vector all[PARTS + 1], wheels[PARTS + 1], target[PARTS + 1];
} Path;

/* About the axis, from the angle `angle` to the target within `time`: what the rods do not shed across the field stays
 * in N. */
static Path path_about(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis, double angle, double time)
{
    const Vector still = s->target.Omega;
    const Vector H = add(apply(s->Q, add(s->H, law->h_target)), apply(law->J, still)), b = apply(s->Q, s->b);
    const double B = larger(norm(b), WHEELS_FIELD_MIN), shed = SURE * SHEDDING_RODS * law->rods_dipole * B;
    const Vector stays = scale(dot(b, H) / (B * B), b), across = subtract(H, stays);
    const double slowly = larger(UNLOADING_SOONER * law->p.unloading_time, norm(across) / shed);
    Path path;
    (void)memset(&path, 0, sizeof path);
    for (int i = 0; i <= PARTS; ++i) {
        const double part = (double)i / (double)PARTS, since = time * (1.0 - part);
        const Matrix left = rotation_exp(scale(angle * part, axis)), moved = rotation_exp(scale(since, still));
        const Vector then = add(stays, scale(exp(-since / slowly), across));
        path.all[i] = apply_transposed(left, apply_transposed(moved, then));
        path.target[i] = apply_transposed(left, still);
        path.wheels[i] = subtract(path.all[i], apply(law->J, path.target[i]));
    }
    return path;
}

/* (3): the rate that the wheels' momenta allow all the way. `coast`: the time with the rate that they allow from there
 * on, at least `least`. */
static double rate_on(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector along, double angle, double least,
                      const Path *path, double *coast)
{
    const double share = law->p.momentum_share * (law->p.wheels > 3 ? BESIDE : 1.0);
    double rate = INFINITY;
    *coast = 0.0;
    for (int i = 0; i <= PARTS; ++i) {
        rate = smaller(rate, zonotope_beside(&s->momentum, share, path->wheels[i], along));
        *coast += i > 0 ? angle / ((double)PARTS * larger(rate, least)) : 0.0;
    }
    return rate;
}

/* (3): the acceleration that the wheels' torques allow all the way, beside the gyroscopic torque at the rates of (4). */
static double acceleration_on(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis, double angle,
                              double rate, const Path *path)
{
    const Vector along = apply(law->J, axis);
    const double share = law->p.torque_share, least = LEAST * s->most / norm(along);
    double a = share * zonotope_reach(&s->torque, 0.0, along), found = a;
    for (int k = 0; k < TORQUE_PASSES; ++k) {
        found = INFINITY;
        for (int i = 0; i <= PARTS; ++i) {
            const double part = (double)i / (double)PARTS;
            const double v = smaller(rate, sqrt(2.0 * a * angle * smaller(part, 1.0 - part)));
            const Vector gyroscopic = cross(subtract(path->target[i], scale(v, axis)), path->all[i]);
            found = smaller(found, zonotope_beside(&s->torque, share, gyroscopic, along));
            found = smaller(found, zonotope_beside(&s->torque, share, gyroscopic, scale(-1.0, along)));
        }
        found = larger(least, found);
        a = sqrt(a * found);
    }
    return smaller(a, found);
}

/* Whether the wheels bear the momentum all the way at the rates at which the turn is braked. */
static bool is_borne(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector along, const SlewTurn *turn,
                     const Path *path)
{
    for (int i = 0; i < PARTS; ++i) {
        const double v = smaller(turn->rate, sqrt(2.0 * turn->acceleration * turn->angle * (double)i / (double)PARTS));
        if (-v > zonotope_beside(&s->momentum, law->p.momentum_share, path->wheels[i], scale(-1.0, along))) {
            return false;
        }
    }
    return true;
}

TurnLimits controller_planned_wheels_turn_about(const ControllerPlannedWheelsLaw *law, const Sample *s, Vector axis,
                                                double angle)
{
    const Vector along = apply(law->J, axis);
    const double ball = SHED_ABOVE * s->momentum.inradius, share = law->p.momentum_share;
    const double size = norm(add(s->H, law->h_target)) + law->J_bound * norm(s->target.Omega);
    const double most = share * zonotope_reach(&s->momentum, 0.0, along);
    const double least =
        size <= ball ? share * zonotope_reach(&s->momentum, size, along) : SLOWEST * most; /* the former in any case */
    TurnLimits found = {.coast = angle / most};
    Path path;
    double rate = most;
    for (int k = 0; k < PASSES; ++k) {
        path = path_about(law, s, axis, angle, found.coast);
        rate = rate_on(law, s, along, angle, least, &path, &found.coast);
    }
    found.turn = (SlewTurn){angle, 0.0, larger(rate, least)};
    found.turn.acceleration = acceleration_on(law, s, axis, angle, found.turn.rate, &path);
    found.fits = size <= ball || (rate > least && is_borne(law, s, along, &found.turn, &path));
    return found;
}

static TurnWay way_of(const ControllerPlannedWheelsLaw *law, const Sample *s, bool other)
{
    const Vector axis = s->angle > 0.0 ? scale((other ? -1.0 : 1.0) / s->angle, s->zeta) : (Vector){1.0, 0.0, 0.0};
    const double angle = other ? 2.0 * REFERENCE_NO_ATTITUDE - s->angle : s->angle; /* that is pi */
    const TurnLimits limits = controller_planned_wheels_turn_about(law, s, axis, angle);
    TurnWay way = {.axis = axis, .turn = limits.turn};
    const double a = way.turn.acceleration, rate = way.turn.rate;
    way.wanted = smaller(rate, sqrt(2.0 * a * angle));
    way.rate = clip(-dot(s->rate, axis), 0.0, way.wanted);
    way.across = add(s->rate, scale(way.rate, axis));
    way.turn.angle += 0.5 * way.rate * way.rate / a;
    way.time = turn_time(&way.turn) - way.rate / a + norm(apply(law->J, way.across)) / s->most;
    way.time += rate < sqrt(a * angle) ? smaller(limits.coast - angle / rate, 0.0) : 0.0;
    way.time = limits.fits ? way.time : INFINITY;
    return way;
}

TurnWay controller_planned_wheels_best_way(const ControllerPlannedWheelsLaw *law, const Sample *s, bool on,
                                           Vector before)
{
    const TurnWay direct = way_of(law, s, false), other = way_of(law, s, true);
    const double stays = !on ? 1.0 : dot(direct.axis, before) > 0.0 ? STAYS : 1.0 / STAYS;
    return direct.time <= stays * other.time ? direct : other;
}

Vector controller_planned_wheels_approach(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                          const ControllerPlannedWheelsState *x)
{
    if (!s->target.attitude) {
        return (Vector){0.0, 0.0, 0.0};
    }
    const TurnWay way = way_of(law, s, dot(s->zeta, x->axis) < 0.0);
    return scale(-way.wanted, way.axis);
}
