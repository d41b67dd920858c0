/* The mode safe: two directions in body axes. Requirement: SV-3. */
#include "safe.h"

static const double FIELD_TIME = 50.0; /* s, of the filter that gives the field's rate */
static const double OPPOSITE = 1e-9;   /* sine of the angle below which opposite directions have no axis between them */
static const double SLOW = 0.3; /* rad in safe_time, below which the satellite turns slowly enough to begin pointing */
static const Vector STILL = {0.0, 0.0, 0.0};

/* The rate that turns a body axis to a unit vector, both in body axes: the angle over `time`, at most rate_max. */
static Vector rate_towards(Vector axis_B, Vector to_B, double time, double rate_max)
{
    Vector about = cross(axis_B, to_B);
    const double s = norm(about), angle = atan2(s, dot(axis_B, to_B));
    if (s < OPPOSITE) {
        if (angle < 1.0) {
            return scale(1.0 / time, about);
        }
        const bool x = fabs(axis_B.x) <= fabs(axis_B.y) && fabs(axis_B.x) <= fabs(axis_B.z);
        about = cross(axis_B, x ? (Vector){1.0, 0.0, 0.0} : (Vector){0.0, 1.0, 0.0});
    }
    return scale(smaller(angle / time, rate_max) / norm(about), about);
}

/* Follows the direction of the field and its rate relative to N. Both are turned by the measured rate, so that the
 * filter sees the slow motion of the field alone; its two poles are at 1/FIELD_TIME. */
static void follow_field(const SupervisorInputs *u, double h, SupervisorState *x)
{
    const Vector b = vector(u->b_B);
    const double size = norm(b);
    if (norm(x->field_direction) > 0.0) {
        const Matrix turned = rotation_exp(scale(-h, vector(u->omega_B)));
        x->field_rate = apply(turned, x->field_rate);
        x->field_direction = apply(rotation_exp(scale(h, x->field_rate)), apply(turned, x->field_direction));
    } else if (size > 0.0) {
        x->field_direction = scale(1.0 / size, b);
    }
    if (size > 0.0 && h > 0.0) {
        const double left = exp(-h / FIELD_TIME);
        const Vector miss = scale(1.0 / size, cross(x->field_direction, b));
        const Vector rate = add(x->field_rate, scale((1.0 - left) * (1.0 - left) / h, miss));
        x->field_direction = apply(rotation_exp(scale(1.0 - left * left, miss)), x->field_direction);
        x->field_direction = scale(1.0 / norm(x->field_direction), x->field_direction);
        x->field_rate = subtract(rate, scale(dot(rate, x->field_direction), x->field_direction));
    }
}

/* Whether it turns at all: the rates are damped first. Rods do not damp a spin about the field, so an axis that
 * points along it would keep its spin, and a fast one upsets the pointing. */
static bool may_turn(const SupervisorParameters *p, const SupervisorInputs *u, const SupervisorState *x)
{
    const bool slow = x->calm >= p->rate_time && norm(vector(u->omega_B)) * p->safe_time < SLOW;
    return slow || (x->calm > 0.0 && norm(x->towards) > 0.0);
}

bool supervisor_point_safe(const SupervisorLaw *law, const SupervisorInputs *u, double h, SupervisorState *x, Fault *f)
{
    const SupervisorParameters *p = &law->p;
    const Vector sun = vector(u->sun_B);
    const bool turns = may_turn(p, u, x);
    Vector axis = vector(p->safe_axis_B), to = STILL, rate = STILL;
    if (p->safe_pointing == SUPERVISOR_SAFE_POINTING_FIELD) {
        if (!supervisor_has_b_B(u)) {
            return fault(f, "b_B", largest(vector(u->b_B)),
                         "a value, since safe_pointing is 'field' (1e9: not connected)");
        }
        follow_field(u, h, x);
        to = x->field_direction;
        rate = x->field_rate;
    } else if (p->safe_pointing == SUPERVISOR_SAFE_POINTING_SUN) {
        if (!supervisor_has_sun_B(u)) {
            return fault(f, "sun_B", largest(sun), "a value, since safe_pointing is 'sun' (1e9: not connected)");
        }
        axis = vector(p->sun_axis_B);
        to = norm(sun) > 0.0 ? scale(1.0 / norm(sun), sun) : STILL;
    }
    x->towards = STILL;
    if (turns && norm(to) > 0.0) {
        const double rate_max =
            smaller(p->slew_rate_max, 0.5 * p->rate_acquire); /* a faster turn would end the pointing */
        x->towards = add(rate_towards(axis, to, p->safe_time, rate_max), rate);
    }
    return true;
}
