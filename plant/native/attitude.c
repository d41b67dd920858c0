#include "attitude.h"

enum { STAGES_MAX = 7 };

typedef struct {
    int stages;
    double shares[STAGES_MAX]; /* of the step */
} Composition;

#define S 0.41449077179437573714 /* 1/(4 - 4^(1/3)) */
#define Y1 (-1.17767998417887)
#define Y2 0.235573213359357
#define Y3 0.784513610477560

static const Composition order_2 = {1, {1.0}};
static const Composition order_4 = {5, {S, S, 1.0 - 4.0 * S, S, S}};
static const Composition order_6 = {7, {Y3, Y2, Y1, 1.0 - 2.0 * (Y1 + Y2 + Y3), Y1, Y2, Y3}};

/* f by Newton's method from 1/2 J^-1 (a - p); false where it does not converge. */
static bool solve_cayley(const Body *body, Vector a, double p, Vector *f)
{
    const Vector wheel = scale(p, body->wheel_axis), difference = subtract(a, wheel), total = add(a, wheel);
    const Matrix J2 = body->J_twice;
    *f = scale(0.5, apply(body->J_inverse, difference));
    for (int i = 0; i < 20; ++i) {
        const double along = dot(total, *f);
        const Vector residual = add(add(difference, cross(a, *f)), subtract(scale(along, *f), apply(J2, *f)));
        /* a^ + (a + p).f I + f (a + p)^T - 2 J */
        const Matrix jacobian = {
            {along + f->x * total.x - J2.a.x, -a.z + f->x * total.y - J2.a.y, a.y + f->x * total.z - J2.a.z},
            {a.z + f->y * total.x - J2.b.x, along + f->y * total.y - J2.b.y, -a.x + f->y * total.z - J2.b.z},
            {-a.y + f->z * total.x - J2.c.x, a.x + f->z * total.y - J2.c.y, along + f->z * total.z - J2.c.z}};
        const Vector change = solve(jacobian, residual);
        *f = subtract(*f, change);
        const double size = dot(change, change);
        if (size <= 1e-18 * (1.0 + dot(*f, *f))) { /* Newton's error squares: what is left is rounding */
            return true;
        }
        if (!(size < 1e12)) {
            return false;
        }
    }
    return false;
}

/* F = (I + f^)(I - f^)^-1 = I + 2/(1 + f.f) (f^ + f^ f^). */
static Matrix cayley(Vector f)
{
    const double c = 2.0 / (1.0 + dot(f, f));
    return (Matrix){{1.0 - c * (f.y * f.y + f.z * f.z), c * (f.x * f.y - f.z), c * (f.x * f.z + f.y)},
                    {c * (f.x * f.y + f.z), 1.0 - c * (f.x * f.x + f.z * f.z), c * (f.y * f.z - f.x)},
                    {c * (f.x * f.z - f.y), c * (f.y * f.z + f.x), 1.0 - c * (f.x * f.x + f.y * f.y)}};
}

bool plant_advance(const Body *body, int order, const Segment *wheel, Moment *moment, Announce *announce, void *context,
                   double t, Attitude *x, Fault *f)
{
    const Composition *composition = order == 2 ? &order_2 : order == 4 ? &order_4 : &order_6;
    double s = 0.0;
    Vector tau = moment(context, &x->R, t);
    for (int i = 0; i < composition->stages; ++i) {
        const double h = composition->shares[i] * wheel->duration;
        const Vector kicked = add(x->Pi, scale(0.5 * h, tau));
        const double p = h * plant_segment_mean(wheel, s, h);
        Vector turn;
        s += h;
        announce(context, t + s);
        if (!solve_cayley(body, scale(h, kicked), p, &turn)) {
            const Vector a = scale(h, kicked);
            return fault(f, "step_max", norm(apply(body->J_inverse, subtract(a, scale(p, body->wheel_axis)))),
                         "a turn below about 1 rad in an internal step, so that the attitude step converges");
        }
        const Matrix F = cayley(turn);
        x->R = multiply(x->R, F);
        tau = moment(context, &x->R, t + s);
        x->Pi = add(apply_transposed(F, kicked), scale(0.5 * h, tau));
    }
    return true;
}
