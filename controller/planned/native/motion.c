/* docs/how/planned.md, Motion. Tests: test_motion.py, test_onboard.py. */
#include "motion.h"

#include "jacobian.h"

static const double BIAS_FADES = 600.0;   /* s, over which the measured bias of the field loses its say */
static const double CHANGE_LASTS = 200.0; /* s, for which a given rate goes on changing as it does now */

Around controller_planned_around_of(const OnboardField *field, const TwoBody *orbit, double t)
{
    Vector r_N, v_N;
    two_body_at(orbit, t, &r_N, &v_N);
    const double r = norm(r_N);
    return (Around){onboard_field_at(field, t, r_N), scale(1.0 / r, r_N), orbit->mu / (r * r * r), {0.0, 0.0, 0.0}};
}

Around controller_planned_around_at(const Ahead *ahead, double t)
{
    Around around = controller_planned_around_of(ahead->field, &ahead->orbit, t);
    const double share = exp(-larger(t - ahead->bias_t, 0.0) / BIAS_FADES);
    around.B_N = add(around.B_N, scale(share, ahead->bias_N));
    if (ahead->profile != NULL) {
        around.change_B = controller_planned_profile_change(ahead->profile, ahead->orbit.t, t);
    }
    return around;
}

/* A motion through two targets with their rates: exp(turn^) from the first, turn a cubic of time. */
static Target between(const Knot *from, const Knot *to, double t)
{
    const double h = to->t - from->t, x = (t - from->t) / h;
    const Vector whole = rotation_log(multiply(transposed(from->target.R), to->target.R));
    const RightJacobian end = right_jacobian_of(norm(whole));
    const Vector first = scale(h, from->target.Omega),
                 last = scale(h, right_jacobian_solve(&end, whole, to->target.Omega));
    const Vector turn = add(add(scale(x * (1.0 + x * (x - 2.0)), first), scale(x * x * (3.0 - 2.0 * x), whole)),
                            scale(x * x * (x - 1.0), last));
    const Vector change = add(add(scale(1.0 + x * (3.0 * x - 4.0), first), scale(6.0 * x * (1.0 - x), whole)),
                              scale(x * (3.0 * x - 2.0), last));
    const RightJacobian now = right_jacobian_of(norm(turn));
    return (Target){multiply(from->target.R, rotation_exp(turn)), scale(1.0 / h, right_jacobian(&now, turn, change))};
}

Target controller_planned_lvlh(Vector r_N, Vector v_N)
{
    const double r = norm(r_N);
    return (Target){lvlh_axes(r_N, v_N), {0.0, -norm(cross(r_N, v_N)) / (r * r), 0.0}};
}

Target controller_planned_target_at(const Ahead *ahead, double t)
{
    if (ahead->knots > 0 && t < ahead->given_t) {
        int i = 0;
        while (i + 1 < ahead->knots && t >= ahead->knot[i + 1].t) {
            ++i;
        }
        return between(&ahead->knot[i], &ahead->knot[i + 1], t);
    }
    if (ahead->target_kind == ONBOARD_TARGET_INERTIAL) {
        return (Target){ahead->R_d0, {0.0, 0.0, 0.0}};
    }
    if (ahead->target_kind == ONBOARD_TARGET_TURNING) {
        const double s = t - ahead->given_t, with_change = clip(s, 0.0, CHANGE_LASTS);
        const Vector turn =
            add(scale(s, ahead->Omega_d0), scale(with_change * (s - 0.5 * with_change), ahead->dOmega_d0));
        return (Target){multiply(ahead->R_d0, rotation_exp(turn)),
                        add(ahead->Omega_d0, scale(with_change, ahead->dOmega_d0))};
    }
    Vector r_N, v_N;
    two_body_at(&ahead->orbit, t, &r_N, &v_N);
    const Target lvlh = controller_planned_lvlh(r_N, v_N);
    return (Target){multiply(lvlh.R, ahead->R_d0), apply_transposed(ahead->R_d0, lvlh.Omega)};
}

/* Of the rods and of the satellite itself. */
static Vector dipole(const Model *model, const double u[CONTROLS])
{
    return add(model->residual_B, rods_dipole(model, u));
}

/* Of field, gravity and disturbance, of the wheel and of the rate itself, N m. */
static Vector torque(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS])
{
    const Vector B = apply_transposed(x->R, around->B_N);
    Vector tau = add(cross(momentum_of(model, x), x->Omega), cross(dipole(model, u), B));
    tau = add(tau, gravity_gradient(model->J, around, x->R));
    tau = add(tau, add(model->disturbance_B, around->change_B));
    return subtract(tau, scale(model->wheel_torque_max * u[3], model->wheel_axis));
}

Vector controller_planned_acceleration(const Model *model, const Around *around, const Motion *x,
                                       const double u[CONTROLS])
{
    return apply(model->J_inverse, torque(model, around, x, u));
}

/* What gives the change of the rate over the first half of a stage: J^-1; or, where nutation is fast, (J - h/2
 * G)^-1. With G = Pi^ the rate of the middle is that of the implicit midpoint rule for a body that turns little in a
 * stage, and its nutation neither grows nor decays, however long the stage is. The derivatives have the whole G, Pi^
 * - Omega^ J, which is the same there. */
static Matrix inverse_over(const Model *model, const Matrix *G, double h)
{
    return inverse(sum(model->J, times(-0.5 * h, *G)));
}

double controller_planned_wheel_within(const Model *model, double l, double u, double h)
{
    if (!has_wheel(model)) {
        return 0.0;
    }
    const double room = 1.0 / (model->wheel_torque_max * h);
    const double v =
        larger(smaller(u, (model->wheel_momentum_max - l) * room), (-model->wheel_momentum_max - l) * room);
    return clip(v, -1.0, 1.0); /* a wheel beyond its limit is brought back as fast as it can be */
}

void controller_planned_moved(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS],
                              double h, Motion *next)
{
    const Vector tau = torque(model, around, x, u);
    Vector first;
    if (model->scales.fast_nutation) {
        const Matrix G = hat(momentum_of(model, x)), J_inverse = inverse_over(model, &G, h);
        first = apply(J_inverse, tau);
    } else {
        first = apply(model->J_inverse, tau);
    }
    const double dl = h * model->wheel_torque_max * u[3];
    const Matrix half = rotation_exp(scale(0.5 * h, x->Omega));
    const Motion middle = {product_of(&x->R, &half), add(x->Omega, scale(0.5 * h, first)), x->l + 0.5 * dl};
    const Vector second = controller_planned_acceleration(model, around, &middle, u);
    const Matrix whole = rotation_exp(scale(h, middle.Omega));
    next->R = product_of(&x->R, &whole);
    next->Omega = add(x->Omega, scale(h, second));
    next->l = x->l + dl;
}

Motion controller_planned_advanced(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS],
                                   double h)
{
    const double v[CONTROLS] = {u[0], u[1], u[2], controller_planned_wheel_within(model, x->l, u[3], h)};
    Motion next;
    controller_planned_moved(model, around, x, v, h, &next);
    return next;
}

/* s I + M. */
static Matrix with_diagonal(double s, Matrix m)
{
    return (Matrix){{m.a.x + s, m.a.y, m.a.z}, {m.b.x, m.b.y + s, m.b.z}, {m.c.x, m.c.y, m.c.z + s}};
}

/* v^ M. */
static Matrix hat_times(Vector v, Matrix m)
{
    return (Matrix){subtract(scale(v.y, m.c), scale(v.z, m.b)), subtract(scale(v.z, m.a), scale(v.x, m.c)),
                    subtract(scale(v.x, m.b), scale(v.y, m.a))};
}

/* M v^. */
static Matrix times_hat(Matrix m, Vector v)
{
    return (Matrix){cross(m.a, v), cross(m.b, v), cross(m.c, v)};
}

/* u^ v^ = v u' - (u'v) I. */
static Matrix hats(Vector u, Vector v)
{
    return with_diagonal(-dot(u, v), (Matrix){scale(v.x, u), scale(v.y, u), scale(v.z, u)});
}

/* J^-1, or what inverse_over has for it, of J d dOmega/dt = Pi x dOmega - Omega x J dOmega - Omega x a dl + m x (B x
 * dtheta) + dM_g, where dM_g = 3 mu/r^3 (rho^ J - (J rho)^) rho^ dtheta. */
typedef struct {
    Matrix J_inverse, angle, rate;
    Vector wheel;
} Jacobian;

static Jacobian jacobian_of(const Model *model, const Around *around, Matrix R, Vector B, Vector Omega, double l,
                            Vector m, double h)
{
    const Matrix J = model->J;
    const Vector rho = apply_transposed(R, around->r_hat_N);
    const Vector Pi = add(apply(J, Omega), momentum_of_wheels(model, l));
    const Matrix by_rate = sum(hat(Pi), times(-1.0, hat_times(Omega, J)));
    const Matrix J_inverse = model->scales.fast_nutation ? inverse_over(model, &by_rate, h) : model->J_inverse;
    const Matrix tilt = sum(hat_times(rho, J), times(-1.0, hat(apply(J, rho))));
    const Matrix angle = sum(hats(m, B), times(3.0 * around->rate_squared, times_hat(tilt, rho)));
    return (Jacobian){
        .J_inverse = J_inverse,
        .angle = multiply(J_inverse, angle),
        .rate = multiply(J_inverse, by_rate),
        .wheel = apply(J_inverse, cross(model->wheel_axis, Omega)),
    };
}

/* The columns of rows `row` to `row` + 2. */
static void put_columns(double columns[][ERRORS], int row, Matrix m)
{
    const Matrix t = transposed(m);
    store(t.a, &columns[0][row]);
    store(t.b, &columns[1][row]);
    store(t.c, &columns[2][row]);
}

void controller_planned_linearise(const Model *model, const Around *around, const Motion *x, const Motion *next,
                                  const double u[CONTROLS], double h, Square A, double G[CONTROLS][ERRORS])
{
    const Vector Omega = scale(0.5, add(x->Omega, next->Omega));
    const Matrix half = rotation_exp(scale(0.5 * h, Omega)), R = product_of(&x->R, &half);
    const Vector B = apply_transposed(R, around->B_N);
    const Jacobian F = jacobian_of(model, around, R, B, Omega, 0.5 * (x->l + next->l), dipole(model, u), h);
    /* A = I + h F + h^2/2 F^2 of F = [-Omega^ I 0; angle rate wheel; 0 0 0]; what its middle row gives over the
     * stage is `over` = h I + h^2/2 rate; h I where nutation is fast, since F then has the rest in it. */
    const bool fast = model->scales.fast_nutation;
    const double s = 0.5 * h * h;
    const Matrix over = with_diagonal(h, times(fast ? 0.0 : s, F.rate));
    const Matrix over_angle = fast ? times(h, F.angle) : multiply(over, F.angle);
    const Matrix over_rate = fast ? times(h, F.rate) : multiply(over, F.rate);
    const Matrix turned = sum(hats(Omega, Omega), F.angle);
    put_columns(A, 0, with_diagonal(1.0, sum(times(-h, hat(Omega)), times(s, turned))));
    put_columns(A, 3, sum(over_angle, times(-s, times_hat(F.angle, Omega))));
    put_columns(A + 3, 0, with_diagonal(h, times(s, sum(F.rate, times(-1.0, hat(Omega))))));
    put_columns(A + 3, 3, with_diagonal(1.0, sum(times(s, F.angle), over_rate)));
    store(scale(s, F.wheel), A[6]);
    store(apply(over, F.wheel), A[6] + 3);
    for (int j = 0; j < ERRORS; ++j) {
        A[j][6] = j == 6 ? 1.0 : 0.0;
    }
    for (int j = 0; j < CONTROLS; ++j) {
        const Vector tau = j < 3 ? cross(model->rods[j], B) : scale(-model->wheel_torque_max, model->wheel_axis);
        const Vector g = apply(F.J_inverse, tau);
        const double l = j < 3 ? 0.0 : model->wheel_torque_max;
        store(scale(s, g), G[j]);
        store(add(apply(over, g), scale(s * l, F.wheel)), G[j] + 3);
        G[j][6] = h * l;
    }
}
