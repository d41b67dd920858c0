/* Tests: tests/native/test_plant.py. */
#include "attitude.h"

enum { STAGES_MAX = 7 };

typedef struct {
    int stages;
    double shares[STAGES_MAX + 1]; /* of the step, and a zero */
} Composition;

#define S 0.41449077179437573714 /* 1/(4 - 4^(1/3)) */
#define Y1 (-1.17767998417887)
#define Y2 0.235573213359357
#define Y3 0.784513610477560

static const Composition order_2 = {1, {1.0}};
static const Composition order_4 = {5, {S, S, 1.0 - 4.0 * S, S, S}};
static const Composition order_6 = {7, {Y3, Y2, Y1, 1.0 - 2.0 * (Y1 + Y2 + Y3), Y1, Y2, Y3}};

/* f by Newton's method from 1/2 J^-1 (a - p); false where it does not converge. The equation is of the second
 * degree, so that ((a + p).c) c is left of it after a change c. */
static bool solve_cayley(const Body *body, Vector a, Vector p, Vector *f)
{
    const Vector difference = subtract(a, p), total = add(a, p);
    const Matrix J2 = body->J_twice;
    *f = scale(0.5, apply(body->J_inverse, difference));
    double along = dot(total, *f);
    Vector residual = add(cross(a, *f), scale(along, *f));
    for (int i = 0; i < 20; ++i) {
        /* a^ + (a + p).f I + f (a + p)^T - 2 J */
        const Matrix jacobian = {
            {along + f->x * total.x - J2.a.x, -a.z + f->x * total.y - J2.a.y, a.y + f->x * total.z - J2.a.z},
            {a.z + f->y * total.x - J2.b.x, along + f->y * total.y - J2.b.y, -a.x + f->y * total.z - J2.b.z},
            {-a.y + f->z * total.x - J2.c.x, a.x + f->z * total.y - J2.c.y, along + f->z * total.z - J2.c.z}};
        const Vector change = solve(jacobian, residual);
        const double along_change = dot(total, change), error = body->compliance * along_change;
        *f = subtract(*f, change);
        if (error * error * dot(change, change) <= 1e-36) { /* rad^2 */
            return true;
        }
        along -= along_change;
        residual = scale(along_change, change);
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

static Vector along_axes(const Body *body, const double l_w[PLANT_WHEELS])
{
    Vector sum = scale(l_w[0], body->wheel_axes[0]);
    for (int i = 1; i < PLANT_WHEELS; ++i) {
        sum = add(sum, scale(l_w[i], body->wheel_axes[i]));
    }
    return sum;
}

Vector plant_wheels_momentum(const Body *body, const double l_w[PLANT_WHEELS], const double angle[PLANT_WHEELS])
{
    const Vector sum = along_axes(body, l_w);
    return body->unbalanced ? add(sum, plant_imbalance_momentum(body->imbalances, angle, l_w)) : sum;
}

bool plant_advance(const Body *body, int order, const Segment wheels[PLANT_WHEELS], const double angle[PLANT_WHEELS],
                   Moment *moment, Announce *announce, void *context, double t, Attitude *x, Fault *f)
{
    const Composition *composition = order == 2 ? &order_2 : order == 4 ? &order_4 : &order_6;
    double before = 0.0, s = 0.0;
    Vector swing = body->unbalanced ? plant_imbalance_swing(body->imbalances, angle) : (Vector){0.0, 0.0, 0.0};
    for (int i = 0;; ++i) {
        const double h = composition->shares[i] * wheels->duration;
        /* The second half of the moment's kick of the substep before, and the first half of this one's. */
        x->Pi = add(x->Pi, scale(0.5 * (before + h), moment(context, &x->R, t + s)));
        if (i == composition->stages) {
            return true;
        }
        const Vector a = scale(h, x->Pi);
        double moved[PLANT_WHEELS]; /* h times the mean of l_w */
        for (int k = 0; k < PLANT_WHEELS; ++k) {
            moved[k] = h * plant_segment_mean(&wheels[k], s, h);
        }
        Vector p = along_axes(body, moved), turn;
        s += h;
        if (body->unbalanced) {
            const Vector start = swing;
            double turned[PLANT_WHEELS];
            plant_imbalance_turned(body->imbalances, wheels, angle, s, turned);
            swing = plant_imbalance_swing(body->imbalances, turned);
            p = add(p, subtract(swing, start));
        }
        announce(context, t + s);
        if (!solve_cayley(body, a, p, &turn)) {
            return fault(f, "step_max", norm(apply(body->J_inverse, subtract(a, p))),
                         "a turn below about 1 rad in an internal step, so that the attitude step converges");
        }
        const Matrix F = cayley(turn);
        x->R = multiply(x->R, F);
        x->Pi = apply_transposed(F, x->Pi);
        before = h;
    }
}
