/* The attitude in which shedding ends: docs/how/planned-wheels.md, Aim. */
#include <string.h>

#include "sample.h"

enum { NODES = 96, DIRECTIONS = 32, STEPS = 6 }; /* of a motion ahead; on a sphere; of a course that is tried */

static const double GOLDEN = 2.3999632297;             /* rad, from direction to direction round the sphere */
static const double TURNED = 57.6;                     /* rad, that a motion ahead rotates at most */
static const double LONGER = 1.3, LEAST_SAMPLES = 4.0; /* than (7) takes; the least time ahead */
static const double REACH = 0.9;                       /* of what the wheels hold */
static const double LEAST_ROOM = 0.15;                 /* of the room for rates of the turn that follows */
static const double MEAN = 2.0 / 3.0;                  /* of J_bound, about the axis of that turn */
static const double DAMPED = 1e-4;                     /* of the mean square of the derivatives */
static const double SOONER = 0.97;                     /* of the time, from which on another course is taken */
static const double SLIP = 0.5, MUCH_LATER = 4.0; /* s per s that the end may recede; times: a turn is no way out */
static const double GIVEN_UP = 60.0;              /* s, that the end is behind: no course comes true */
static const double FAR = 0.6, NEAR = 0.3;        /* from lambda, of those that are tried */

/* What is the same for all motions ahead. */
typedef struct {
    Matrix inverse, R; /* of the inertia; body to N */
    Vector H;          /* N m s, of all, in N */
    double limits[3];  /* A m2, of the rods */
    FieldAhead field;
    double time; /* s, of the motion */
} Coming;

/* Where the turn that follows is soonest over. */
typedef struct {
    double whole, time;             /* s, until that turn is over, and until it begins; infinite: nowhere */
    Vector zeta;                    /* rad, that is left for it */
    Matrix moved[AIM_COURSE_KNOTS]; /* rad/(N m s), of the attitude there by each knot */
} Arrival;

/* v, or as much of it as the wheels hold. */
static Vector within(const Sample *s, Vector v)
{
    const Vector none = {0.0, 0.0, 0.0};
    return scale(smaller(1.0, zonotope_beside(&s->momentum, REACH, none, v)), v);
}

/* The knot that the wheels go to `time` s from now. */
static int knot_at(const Aim *aim, double time)
{
    return whole_part(smaller((time + aim->since) / aim->segment, (double)AIM_COURSE_KNOTS - 0.5),
                      AIM_COURSE_KNOTS - 1);
}

/* The wheels' momentum `time` s from now: from knot to knot with their torque. */
static Vector momentum_at(const Sample *s, const Aim *aim, const AimCourse *course, double time)
{
    const int k = knot_at(aim, time);
    const Vector from = k == 0 ? s->h : course->knots[k - 1], change = subtract(course->knots[k], from);
    const double gone = k == 0 ? time : time + aim->since - (double)k * aim->segment, size = norm(change);
    return add(from, scale(size > 0.0 ? smaller(1.0, gone * s->most / size) : 1.0, change));
}

/* (16): what is left if shedding ends in attitude R, `time` s from now, with the momentum H of all. */
static void look_at_end(const ControllerPlannedWheelsLaw *law, const Sample *s, Matrix R, Vector Omega, Vector H,
                        double time, const Matrix moved[AIM_COURSE_KNOTS], Arrival *best)
{
    const double size = norm(H), room = ROOM * s->momentum.inradius;
    if (size > SHED_TO * s->momentum.inradius) {
        return;
    }
    const Matrix target = multiply(s->target.R, rotation_exp(scale(time, s->target.Omega)));
    const Matrix Q = multiply(transposed(target), R);
    const Vector rate = subtract(Omega, apply_transposed(Q, s->target.Omega));
    const double brake = norm(apply(law->J, rate)) / s->most, J = MEAN * law->J_bound;
    const Vector zeta = rotation_log(multiply(Q, rotation_exp(scale(0.5 * brake, rate))));
    const SlewTurn turn = {norm(zeta), s->most / J, larger(room - size, LEAST_ROOM * room) / J};
    const double whole = time + brake + turn_time(&turn);
    if (whole < best->whole) {
        best->whole = whole;
        best->time = time;
        best->zeta = zeta;
        (void)memcpy(best->moved, moved, sizeof best->moved);
    }
}

/* (15): the best end of the motion ahead on that course. */
static void arrive(const ControllerPlannedWheelsLaw *law, const Sample *s, const Coming *coming, const Aim *aim,
                   const AimCourse *course, Arrival *best)
{
    const double h = coming->time / (double)NODES;
    Matrix R = coming->R, moved[AIM_COURSE_KNOTS];
    Vector H = coming->H;
    (void)memset(best, 0, sizeof *best);
    (void)memset(moved, 0, sizeof moved);
    best->whole = INFINITY;
    best->time = INFINITY;
    for (int i = 0; i <= NODES; ++i) {
        const double time = h * (double)i, middle = time + 0.5 * h;
        const Vector before = subtract(apply_transposed(R, H), momentum_at(s, aim, course, time));
        const Vector Omega = apply(coming->inverse, before);
        look_at_end(law, s, R, Omega, H, time, moved, best);
        const Matrix half = multiply(R, rotation_exp(scale(0.5 * h, Omega)));
        const Vector b = apply_transposed(half, field_at(&coming->field, middle * coming->field.rate));
        const Vector along = apply_transposed(half, course->lambda);
        const Vector dipole = shedding_dipole(law->rods, 1.0, coming->limits, along, b);
        const Vector torque = apply(half, cross(apply_transposed(law->rods, dipole), b));
        const Vector all = apply_transposed(half, add(H, scale(0.5 * h, torque)));
        const Vector rate = apply(coming->inverse, subtract(all, momentum_at(s, aim, course, middle)));
        const Matrix step = rotation_exp(scale(h, rate)), by = multiply(coming->inverse, hat(all));
        const int knot = knot_at(aim, middle);
        for (int k = 0; k < AIM_COURSE_KNOTS; ++k) {
            const Matrix then = add_scaled(moved[k], h, multiply(by, moved[k]));
            moved[k] = add_scaled(multiply(transposed(step), then), k == knot ? -h : 0.0, coming->inverse);
        }
        R = multiply(R, step);
        H = add(H, scale(h, torque));
    }
}

/* A step of Gauss and Newton to no angle left where the motion arrives, the least one. */
static void improve(const Sample *s, const Arrival *there, AimCourse *course)
{
    Matrix normal = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int k = 0; k < AIM_COURSE_KNOTS; ++k) {
        normal = add_scaled(normal, 1.0, multiply(there->moved[k], transposed(there->moved[k])));
    }
    const double trace = normal.a.x + normal.b.y + normal.c.z;
    if (!(trace > 0.0)) {
        return;
    }
    const Vector y = solve(add_scaled(normal, DAMPED * trace, identity), there->zeta);
    for (int k = 0; k < AIM_COURSE_KNOTS; ++k) {
        course->knots[k] = within(s, subtract(course->knots[k], apply_transposed(there->moved[k], y)));
    }
}

/* Directions over a sphere, one after the other. */
static Vector direction_of(int32_t number)
{
    const double z = 1.0 - (2.0 * (double)number + 1.0) / (double)DIRECTIONS;
    const double round = GOLDEN * (double)number, across = sqrt(larger(1.0 - z * z, 0.0));
    return (Vector){across * cos(round), across * sin(round), z};
}

/* Another course: with other momenta, or another direction in which the rods shed. */
static void try_next(const Sample *s, const Coming *coming, Vector lambda, int32_t number, Aim *aim)
{
    const Vector direct = direction_of(number);
    aim->other = aim->course;
    if (number % 2 == 0) {
        const Vector wheels = within(s, scale(s->momentum.inradius, direct));
        for (int k = 0; k < AIM_COURSE_KNOTS; ++k) {
            aim->other.knots[k] = wheels;
        }
    } else if (number % 8 == 1) {
        aim->other.lambda = lambda;
    } else if (number % 8 == 5) {
        aim->other.lambda = direction(norm(coming->H), coming->H);
    } else {
        const Vector other = add(aim->course.lambda, scale(number % 8 == 3 ? FAR : NEAR, direct));
        aim->other.lambda = direction(norm(other), other);
    }
}

static void begin(const Sample *s, const Coming *coming, Vector lambda, Aim *aim)
{
    aim->segment = coming->time / (double)AIM_COURSE_KNOTS;
    aim->since = 0.0;
    aim->tries = 0;
    aim->left = 2.0 * coming->time;
    aim->given_up = false;
    aim->course.lambda = lambda;
    for (int k = 0; k < AIM_COURSE_KNOTS; ++k) {
        aim->course.knots[k] = s->h;
    }
    aim->other = aim->course;
}

/* On to the next knot. */
static void pass_knot(Aim *aim)
{
    aim->since = 0.0;
    for (int k = 0; k < AIM_COURSE_KNOTS - 1; ++k) {
        aim->course.knots[k] = aim->course.knots[k + 1];
        aim->other.knots[k] = aim->other.knots[k + 1];
    }
}

bool controller_planned_wheels_aim(const ControllerPlannedWheelsLaw *law, const Sample *s,
                                   const ControllerPlannedWheelsInputs *u, const FieldAhead *field,
                                   const Shedding *shedding, double turn, bool first, ControllerPlannedWheelsState *x)
{
    const ControllerPlannedWheelsParameters *p = &law->p;
    const Matrix R = matrix(u->R_NB);
    const Vector body = apply(law->J, vector(u->omega_B)), all = add(body, s->h), gains = x->rod_gains;
    const double gain[3] = {gains.x, gains.y, gains.z};
    Coming coming = {.inverse = inverse(law->J), .R = R, .H = apply(R, all), .field = *field};
    for (int i = 0; i < 3; ++i) {
        coming.limits[i] = p->dipole_max * p->rod_limits[i] * gain[i];
    }
    coming.time = LONGER * shedding->time + LEAST_SAMPLES * p->command_period;
    Aim *aim = &x->aim;
    if (!(field->rate > 0.0) || shedding->time * norm(vector(u->omega_B)) > TURNED) {
        aim->segment = 0.0;
        return false;
    }
    aim->since += p->command_period;
    if (first || aim->segment <= 0.0) {
        begin(s, &coming, shedding->lambda, aim);
    } else if (aim->since >= aim->segment) {
        pass_knot(aim);
    }
    Arrival best, there;
    arrive(law, s, &coming, aim, &aim->course, &best);
    AimCourse next = aim->course;
    improve(s, &best, &next);
    arrive(law, s, &coming, aim, &next, &there);
    if (there.whole < best.whole) {
        aim->course = next;
        best = there;
    }
    arrive(law, s, &coming, aim, &aim->other, &there);
    if (there.whole < SOONER * best.whole) {
        aim->course = aim->other;
        best = there;
    }
    aim->tries = (aim->tries + 1) % (STEPS * DIRECTIONS);
    if (aim->tries % STEPS == 0) {
        try_next(s, &coming, shedding->lambda, aim->tries / STEPS, aim);
    } else {
        improve(s, &there, &aim->other);
    }
    aim->given_up = aim->left < -GIVEN_UP;
    aim->whole = aim->given_up ? INFINITY : best.whole;
    aim->left = smaller(aim->left - SLIP * p->command_period, best.time);
    return aim->left > 0.0 || turn > MUCH_LATER * best.whole || norm(all) > SHED_TO * s->momentum.inradius;
}
