/* Attitude at the end of shedding: docs/how/planned-wheels.md, Aim. */
#include <string.h>

#include "reference.h"
#include "sample.h"

enum { NODES = 96, DIRECTIONS = 32, TRIES = 6 }; /* of a motion ahead; of momenta that are tried; steps for each */
static const double NODE = 0.3;                  /* rad, of the rotation from node to node at most */
static const double REACH = 0.9;                 /* of what the wheels hold */
static const double DAMPED = 1e-4;               /* of the mean square of the derivatives */
static const double SOONER = 0.97; /* of the time to the end, from sample to sample */
static const double GOLDEN = 2.3999632297;       /* rad, from direction to direction on a sphere */
static const double SHORTEST = 4.0;              /* samples, of a motion ahead */

/* What is the same for all motions ahead. */
typedef struct {
    Matrix inverse, R; /* of the inertia; body to N */
    Vector H;          /* of all, in N */
    double limits[3];  /* A m2, of each rod */
    FieldAhead field;
} Coming;

/* Where the turn that follows is soonest over: when, its angle, and how knots move it. */
typedef struct {
    Vector zeta;
    Matrix moved[AIM_KNOTS]; /* 1/(N m s) */
    double whole, time;      /* s; infinite: the wheels do not hold what there is */
} Arrival;

/* Momentum of the wheels `time` s from now, and the knot that it belongs to. */
static Vector momentum_at(const Sample *s, double segment, double since, const Vector knots[AIM_KNOTS], double time, int *knot)
{
    const double place = (time + since) / segment;
    const int k = whole_part(smaller(place, (double)AIM_KNOTS - 0.5), AIM_KNOTS - 1);
    const Vector from = k == 0 ? s->h : knots[k - 1], change = subtract(knots[k], from);
    const double gone = k == 0 ? time : time + since - segment * (double)k;
    const double size = norm(change);
    *knot = k;
    return add(from, scale(size > 0.0 ? smaller(1.0, gone * s->most / size) : 1.0, change));
}

static double turned_in(const ControllerPlannedWheelsLaw *law, const Sample *s, double angle, double H)
{
    const double J = law->J_bound * 2.0 / 3.0, room = 1.15 * s->momentum.inradius;
    return turn_time(&(SlewTurn){angle, s->most / J, larger(room - H, 0.15 * room) / J});
}

/* (14): the motion over `time` s with the momenta `knots` in the wheels, in body axes. */
static void arrive(const ControllerPlannedWheelsLaw *law, const Sample *s, const Coming *coming, const Aim *aim, double time,
                   Vector along, const Vector knots[AIM_KNOTS], Arrival *end)
{
    const double h = time / (double)NODES;
    Matrix R = coming->R, by_knots[AIM_KNOTS];
    Vector H = coming->H;
    (void)memset(end, 0, sizeof *end);
    (void)memset(by_knots, 0, sizeof by_knots);
    end->whole = INFINITY;
    for (int i = 0; i <= NODES; ++i) {
        const double middle = ((double)i + 0.5) / (double)NODES, t = h * (double)i;
        int knot;
        const Vector w = momentum_at(s, aim->segment, aim->since, knots, t, &knot);
        const Vector Omega = apply(coming->inverse, subtract(apply_transposed(R, H), w));
        const Matrix target = multiply(s->target.R, rotation_exp(scale(t, s->target.Omega)));
        if (controller_planned_wheels_held(s, apply_transposed(target, H)) >= norm(H)) {
            const Matrix Q = multiply(transposed(target), R);
            const Vector rate = subtract(Omega, apply_transposed(Q, s->target.Omega));
            const double brake = norm(apply(law->J, rate)) / s->most;
            const Vector zeta = rotation_log(multiply(Q, rotation_exp(scale(0.5 * brake, rate))));
            const double whole = t + brake + turned_in(law, s, norm(zeta), norm(H));
            if (whole < end->whole) {
                end->whole = whole;
                end->time = t;
                end->zeta = zeta;
                (void)memcpy(end->moved, by_knots, sizeof by_knots);
            }
        }
        const Matrix half = multiply(R, rotation_exp(scale(0.5 * h, Omega)));
        const Vector b = apply_transposed(half, field_at(&coming->field, middle * time * coming->field.rate));
        const Vector lambda = apply_transposed(half, along);
        const Vector dipole = shedding_dipole(law->rods, 1.0, coming->limits, lambda, b);
        const Vector torque = apply(half, cross(apply_transposed(law->rods, dipole), b));
        const Vector all = apply_transposed(half, add(H, scale(0.5 * h, torque)));
        const Vector mean = apply(coming->inverse, subtract(all, momentum_at(s, aim->segment, aim->since, knots, middle * time, &knot)));
        const Matrix step = rotation_exp(scale(h, mean)), by = multiply(coming->inverse, hat(all));
        R = multiply(R, step);
        H = add(H, scale(h, torque));
        for (int k = 0; k < AIM_KNOTS; ++k) {
            const Matrix moved = add_scaled(by_knots[k], h, multiply(by, by_knots[k]));
            by_knots[k] = add_scaled(multiply(transposed(step), moved), k == knot ? -h : 0.0, coming->inverse);
        }
    }
}

double controller_planned_wheels_held(const Sample *s, Vector along)
{
    const Vector none = {0.0, 0.0, 0.0};
    return SHED_ABOVE * norm(along) * zonotope_beside(&s->momentum, 1.0, none, along);
}

/* At most what the wheels hold. */
static Vector within(const Sample *s, Vector v)
{
    return scale(smaller(1.0, zonotope_beside(&s->momentum, REACH, (Vector){0.0, 0.0, 0.0}, v)), v);
}

/* A step of Gauss and Newton towards no error at the end, the least change. */
static void improve(const Sample *s, const Arrival *end, Vector knots[AIM_KNOTS])
{
    Matrix normal = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int k = 0; k < AIM_KNOTS; ++k) {
        normal = add_scaled(normal, 1.0, multiply(end->moved[k], transposed(end->moved[k])));
    }
    const double trace = normal.a.x + normal.b.y + normal.c.z;
    if (!(trace > 0.0)) {
        return;
    }
    const Vector y = solve(add_scaled(normal, DAMPED * trace, identity), end->zeta);
    for (int k = 0; k < AIM_KNOTS; ++k) {
        const Vector changed = subtract(knots[k], apply_transposed(end->moved[k], y));
        knots[k] = within(s, changed);
    }
}

/* Momenta over the directions of a sphere, one after the other. */
static void try_next(const Sample *s, int32_t tries, Vector knots[])
{
    const double z = 1.0 - (2.0 * (double)tries + 1.0) / (double)DIRECTIONS;
    const double round = GOLDEN * (double)tries, across = sqrt(larger(1.0 - z * z, 0.0));
    const double most = (tries % 2 == 0 ? 1.0 : 0.5) * s->momentum.inradius;
    for (int k = 0; k < 1; ++k) {
        knots[k] = within(s, scale(most, (Vector){across * cos(round), across * sin(round), z}));
    }
}

void controller_planned_wheels_aim(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                   const ControllerPlannedWheelsInputs *u, const Shedding *shedding, Vector gains,
                                   bool first, Aim *aim)
{
    const Matrix R = matrix(u->R_NB);
    Coming coming = {.inverse = inverse(law->J), .R = R};
    const Vector all = add(apply(law->J, vector(u->omega_B)), s->h);
    const double *limits = law->p.rod_limits, most = law->p.dipole_max;
    coming.H = apply(R, all);
    coming.limits[0] = most * limits[0] * gains.x;
    coming.limits[1] = most * limits[1] * gains.y;
    coming.limits[2] = most * limits[2] * gains.z;
    coming.field = field_ahead(apply(R, s->b), vector(u->r_N), vector(u->v_N));
    const double shortest = SHORTEST * law->p.command_period;
    const double rate = norm(apply(coming.inverse, subtract(all, s->h)));
    aim->whole = INFINITY;
    if (!(coming.field.rate > 0.0) || shedding->time * rate > 2.0 * NODE * (double)NODES) {
        aim->segment = 0.0;
        return;
    }
    const double horizon = 1.3 * shedding->time + shortest;
    aim->since += law->p.command_period;
    if (first || aim->segment <= 0.0) {
        aim->segment = horizon / (double)AIM_KNOTS;
        aim->since = 0.0;
        aim->tries = 0;
        aim->lambda = shedding->lambda;
        aim->other_lambda = shedding->lambda;
        for (int k = 0; k < AIM_KNOTS; ++k) {
            aim->knots[k] = s->h;
            aim->other[k] = s->h;
        }
    }
    if (aim->since >= aim->segment) {
        aim->since = 0.0;
        for (int k = 0; k < AIM_KNOTS - 1; ++k) {
            aim->knots[k] = aim->knots[k + 1];
            aim->other[k] = aim->other[k + 1];
        }
    }
    Arrival best, other, next;
    Vector knots[AIM_KNOTS];
    arrive(law, s, &coming, aim, horizon, aim->lambda, aim->knots, &best);
    (void)memcpy(knots, aim->knots, sizeof knots);
    improve(s, &best, knots);
    arrive(law, s, &coming, aim, horizon, aim->lambda, knots, &next);
    if (next.whole < best.whole) {
        (void)memcpy(aim->knots, knots, sizeof knots);
        best = next;
    }
    arrive(law, s, &coming, aim, horizon, aim->other_lambda, aim->other, &other);
    if (other.whole < SOONER * best.whole) {
        (void)memcpy(aim->knots, aim->other, sizeof knots);
        aim->lambda = aim->other_lambda;
        best = other;
    }
    aim->tries = (aim->tries + 1) % (TRIES * DIRECTIONS);
    if (aim->tries % TRIES == 0) {
        const int32_t tries = aim->tries / TRIES;
        if (tries % 2 == 0) {
            try_next(s, tries, aim->other);
            for (int k = 1; k < AIM_KNOTS; ++k) {
                aim->other[k] = aim->other[0];
            }
            aim->other_lambda = aim->lambda;
        } else {
            Vector direct[1];
            try_next(s, tries, direct);
            (void)memcpy(aim->other, aim->knots, sizeof knots);
            aim->other_lambda = tries % 8 == 1   ? shedding->lambda
                                : tries % 8 == 5 ? direction(norm(coming.H), coming.H)
                                                 : add(aim->lambda, scale((tries % 8 == 3 ? 0.6 : 0.3) / norm(direct[0]), direct[0]));
            aim->other_lambda = direction(norm(aim->other_lambda), aim->other_lambda);
        }
    } else {
        improve(s, &other, aim->other);
    }
    aim->angle = norm(best.zeta);
    aim->whole = best.whole;
    aim->waits = true;
    if (controller_planned_wheels_held(s, apply(s->Q, all)) >= norm(all)) {
        aim->waits = best.time > 0.0 && best.time < INFINITY;
    }
}
