/* Differential dynamic programming with bounded controls: Tassa, Mansard and Todorov, ICRA 2014; errors of attitude in
 * body axes, R exp(d^). */
#include "plan.h"

#include <string.h>

static const double WEIGHT_ANGLE = 10.0, BEND = 0.1;   /* of the pseudo-Huber cost of the angle; rad */
static const double WEIGHT_RATE = 2000.0;              /* s^2 */
static const double WEIGHT_WHEEL = 20.0;               /* 1/(N m s)^2 */
static const double WEIGHT_WHEEL_NEAR_LIMIT = 3e5;     /* 1/(N m s)^2, beyond WHEEL_NEAR_LIMIT of its limit */
static const double WHEEL_NEAR_LIMIT = 0.8667;
static const double WEIGHT_CONTROL = 0.005;
static const double FINAL = 300.0, FINAL_WHEEL = 30.0; /* s, by which the last stage counts */
static const double NEAR = 500.0, HORIZON = 1500.0;    /* s */
static const double STAGE_NEAR = 10.0, STAGE_FAR = 25.0;
static const double FAST = 0.04, FASTER = 0.08;        /* rad/s; stages are halved and quartered */
static const double TURN_MAX = 1.5;                    /* rad in a stage; a motion beyond is no plan */
static const double BIAS_FADES = 600.0;                 /* s */
static const double NEVER = 1e300;
static const int ITERATIONS_COLD = 60;                 /* of a start of a search */
static const double CASCADE_RATES[STARTS - 1] = {0.008, 0.02}; /* rad/s; the first start has no controls */

Around around_at(const Ahead *ahead, double t)
{
    Vector r_N, v_N;
    onboard_orbit_at(&ahead->orbit, t, &r_N, &v_N);
    const double r = norm(r_N);
    const double share = exp(-larger(t - ahead->bias_t, 0.0) / BIAS_FADES);
    return (Around){add(onboard_field_at(ahead->field, t, r_N), scale(share, ahead->bias_N)), scale(1.0 / r, r_N),
                    ahead->orbit.mu / (r * r * r)};
}

Target target_at(const Ahead *ahead, double t)
{
    Vector r_N, v_N;
    onboard_orbit_at(&ahead->orbit, t, &r_N, &v_N);
    return target_of(ahead->target_kind, ahead->R_d0, r_N, v_N);
}

Vector rods_dipole(const Model *model, const double u[CONTROLS])
{
    return add(scale(u[0], model->rods[0]), add(scale(u[1], model->rods[1]), scale(u[2], model->rods[2])));
}

Vector gravity_gradient(Matrix J, const Around *around, Matrix R)
{
    const Vector rho = apply_transposed(R, around->r_hat_N);
    return scale(3.0 * around->rate_squared, cross(rho, apply(J, rho)));
}

bool may_be_flown(const Plan *plan)
{
    return plan->cost < NEVER;
}

/* Of the rods and of the satellite itself. */
static Vector dipole(const Model *model, const double u[CONTROLS])
{
    return add(model->residual_B, rods_dipole(model, u));
}

Vector acceleration(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS])
{
    const Vector B = apply_transposed(x->R, around->B_N);
    Vector Pi = apply(model->J, x->Omega);
    Pi.x += x->l;
    Vector tau = add(cross(Pi, x->Omega), cross(dipole(model, u), B));
    tau = add(tau, gravity_gradient(model->J, around, x->R));
    tau = add(tau, model->disturbance_B);
    tau.x -= model->wheel_torque_max * u[3];
    return apply(model->J_inverse, tau);
}

/* The wheel's control within what its momentum leaves room for. */
static double wheel_within(const Model *model, double l, double u, double h)
{
    const double room = 1.0 / (model->wheel_torque_max * h);
    const double v = larger(smaller(u, (model->wheel_momentum_max - l) * room), (-model->wheel_momentum_max - l) * room);
    return larger(smaller(v, 1.0), -1.0); /* a wheel beyond its limit is brought back as fast as it can be */
}

static Motion moved(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS], double h)
{
    const Vector first = acceleration(model, around, x, u);
    const double dl = h * model->wheel_torque_max * u[3];
    const Motion middle = {multiply(x->R, rotation_exp(scale(0.5 * h, x->Omega))), add(x->Omega, scale(0.5 * h, first)),
                           x->l + 0.5 * dl};
    const Vector second = acceleration(model, around, &middle, u);
    return (Motion){multiply(x->R, rotation_exp(scale(h, middle.Omega))), add(x->Omega, scale(h, second)), x->l + dl};
}

Motion advanced(const Model *model, const Around *around, const Motion *x, const double u[CONTROLS], double h)
{
    const double v[CONTROLS] = {u[0], u[1], u[2], wheel_within(model, x->l, u[3], h)};
    return moved(model, around, x, v, h);
}

/* Gradient and (Gauss-Newton) Hessian of the cost rate of a motion; returns the cost rate. */
static double cost_of(const Model *model, const Target *target, const Motion *x, double scale_errors, double scale_wheel,
                      double gradient[ERRORS], double hessian[ERRORS])
{
    const Matrix Q = multiply(transposed(target->R), x->R);
    const Vector zeta = rotation_log(Q), w = apply_transposed(Q, target->Omega);
    const Vector omega = subtract(x->Omega, w);
    const double root = sqrt(dot(zeta, zeta) + BEND * BEND);
    const double near = WHEEL_NEAR_LIMIT * model->wheel_momentum_max;
    const double over = x->l > near ? x->l - near : x->l < -near ? x->l + near : 0.0;
    if (gradient != NULL) {
        const double a = scale_errors * WEIGHT_ANGLE * BEND / root, b = scale_errors * WEIGHT_RATE;
        /* d omega = d Omega - w x d theta */
        const Vector by_angle = add(scale(a, zeta), scale(b, cross(w, omega)));
        store(by_angle, gradient);
        store(scale(b, omega), gradient + 3);
        gradient[6] = scale_wheel * (WEIGHT_WHEEL * x->l + WEIGHT_WHEEL_NEAR_LIMIT * over);
        for (int i = 0; i < 3; ++i) {
            hessian[i] = a;
            hessian[3 + i] = b;
        }
        hessian[6] = scale_wheel * (WEIGHT_WHEEL + (over != 0.0 ? WEIGHT_WHEEL_NEAR_LIMIT : 0.0));
    }
    return scale_errors * (WEIGHT_ANGLE * BEND * (root - BEND) + 0.5 * WEIGHT_RATE * dot(omega, omega)) +
           scale_wheel * 0.5 * (WEIGHT_WHEEL * x->l * x->l + WEIGHT_WHEEL_NEAR_LIMIT * over * over);
}

static double control_cost(const double u[CONTROLS])
{
    return WEIGHT_CONTROL * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2] + u[3] * u[3]);
}

/* Motion and cost of the controls in `from` plus share k + K errors, into `to`; NEVER where it turns too fast. */
static double roll_out(const Model *model, const Plan *plan, Workspace *w, int from, int to, double share)
{
    double cost = 0.0;
    for (int i = 0; i < plan->stages; ++i) {
        const Motion *x = &w->x[to][i], *x0 = &w->x[from][i];
        const double h = plan->h[i];
        double *u = w->u[to][i];
        memcpy(u, w->u[from][i], sizeof w->u[from][i]);
        if (share > 0.0) {
            double error[ERRORS];
            store(rotation_log(multiply(transposed(x0->R), x->R)), error);
            store(subtract(x->Omega, x0->Omega), error + 3);
            error[6] = x->l - x0->l;
            for (int j = 0; j < CONTROLS; ++j) {
                double change = share * w->k[i][j];
                for (int m = 0; m < ERRORS; ++m) {
                    change += w->K[i][j][m] * error[m];
                }
                u[j] = larger(smaller(u[j] + change, 1.0), -1.0);
            }
        }
        u[3] = wheel_within(model, x->l, u[3], h);
        if (!(norm(x->Omega) * h < TURN_MAX)) {
            return NEVER;
        }
        cost += h * (cost_of(model, &w->stage[i].target, x, 1.0, 1.0, NULL, NULL) + control_cost(u));
        w->x[to][i + 1] = moved(model, &w->stage[i].around, x, u, h);
    }
    cost += cost_of(model, &w->stage[plan->stages].target, &w->x[to][plan->stages], FINAL, FINAL_WHEEL, NULL, NULL);
    return cost == cost ? cost : NEVER;
}

static void put_block(Square F, int row, int column, double factor, Matrix m)
{
    const Vector rows[3] = {m.a, m.b, m.c};
    for (int i = 0; i < 3; ++i) {
        F[row + i][column] += factor * rows[i].x;
        F[row + i][column + 1] += factor * rows[i].y;
        F[row + i][column + 2] += factor * rows[i].z;
    }
}

static Matrix hat(Vector v)
{
    return (Matrix){{0.0, -v.z, v.y}, {v.z, 0.0, -v.x}, {-v.y, v.x, 0.0}};
}

static Matrix sum(Matrix m, Matrix n)
{
    return (Matrix){add(m.a, n.a), add(m.b, n.b), add(m.c, n.c)};
}

static Matrix times(double s, Matrix m)
{
    return (Matrix){scale(s, m.a), scale(s, m.b), scale(s, m.c)};
}

/* The errors after a stage, A errors + G controls, to second order in h, with the motion of its middle. */
static void linearise(const Model *model, const Around *around, const Motion *x, const Motion *next, const double u[CONTROLS],
                      double h, Square A, double G[ERRORS][CONTROLS])
{
    const Vector Omega = scale(0.5, add(x->Omega, next->Omega));
    const Matrix R = multiply(x->R, rotation_exp(scale(0.5 * h, Omega)));
    const Vector B = apply_transposed(R, around->B_N), rho = apply_transposed(R, around->r_hat_N);
    const Matrix J = model->J;
    Vector Pi = apply(J, Omega);
    Pi.x += 0.5 * (x->l + next->l);

    /* J d dOmega/dt = Pi x dOmega - Omega x J dOmega - Omega x e1 dl + m x (B x dtheta) + dM_g */
    const Matrix rate = multiply(model->J_inverse, sum(hat(Pi), times(-1.0, multiply(hat(Omega), J))));
    const Vector m = dipole(model, u);
    const Matrix magnetic = multiply(hat(m), hat(B));
    const Matrix gravity = times(3.0 * around->rate_squared,
                                 sum(multiply(hat(rho), multiply(J, hat(rho))), times(-1.0, multiply(hat(apply(J, rho)), hat(rho)))));
    const Matrix angle = multiply(model->J_inverse, sum(magnetic, gravity));
    const Vector wheel = apply(model->J_inverse, (Vector){0.0, -Omega.z, Omega.y});
    const Matrix turn = times(-1.0, hat(Omega));

    /* F = [turn I 0; angle rate wheel; 0 0 0], A = I + h F + h^2/2 F^2. */
    const double s = 0.5 * h * h;
    memset(A, 0, sizeof(Square));
    put_block(A, 0, 0, 1.0, identity);
    put_block(A, 0, 0, h, turn);
    put_block(A, 0, 0, s, sum(multiply(turn, turn), angle));
    put_block(A, 0, 3, h, identity);
    put_block(A, 0, 3, s, sum(turn, rate));
    put_block(A, 3, 0, h, angle);
    put_block(A, 3, 0, s, sum(multiply(angle, turn), multiply(rate, angle)));
    put_block(A, 3, 3, 1.0, identity);
    put_block(A, 3, 3, h, rate);
    put_block(A, 3, 3, s, sum(angle, multiply(rate, rate)));
    const Vector rate_wheel = apply(rate, wheel);
    double column[3];
    store(scale(s, wheel), column);
    A[0][6] = column[0], A[1][6] = column[1], A[2][6] = column[2];
    store(add(scale(h, wheel), scale(s, rate_wheel)), column);
    A[3][6] = column[0], A[4][6] = column[1], A[5][6] = column[2];
    A[6][6] = 1.0;

    for (int j = 0; j < CONTROLS; ++j) {
        const Vector tau = j < 3 ? cross(model->rods[j], B) : (Vector){-model->wheel_torque_max, 0.0, 0.0};
        const Vector g = apply(model->J_inverse, tau);
        const double l = j < 3 ? 0.0 : model->wheel_torque_max;
        double top[3], middle[3];
        store(scale(s, g), top);
        store(add(scale(h, g), scale(s, add(apply(rate, g), scale(l, wheel)))), middle);
        for (int i = 0; i < 3; ++i) {
            G[i][j] = top[i];
            G[3 + i][j] = middle[i];
        }
        G[6][j] = h * l;
    }
}

/* Gains of all stages for the motion in `at`. */
static void sweep_back(const Model *model, const Plan *plan, Workspace *w, int at)
{
    Sweep *s = &w->sweep;
    double v[ERRORS], diagonal[ERRORS];
    memset(s->V, 0, sizeof s->V);
    const int n = plan->stages;
    cost_of(model, &w->stage[n].target, &w->x[at][n], FINAL, FINAL_WHEEL, v, diagonal);
    for (int i = 0; i < ERRORS; ++i) {
        s->V[i][i] = diagonal[i];
    }
    for (int i = n - 1; i >= 0; --i) {
        const double h = plan->h[i];
        const double *u = w->u[at][i];
        linearise(model, &w->stage[i].around, &w->x[at][i], &w->x[at][i + 1], u, h, s->A, s->G);
        double gradient[ERRORS];
        cost_of(model, &w->stage[i].target, &w->x[at][i], h, h, gradient, diagonal);
        for (int a = 0; a < ERRORS; ++a) {
            for (int b = 0; b < ERRORS; ++b) {
                double x = 0.0;
                for (int c = 0; c < ERRORS; ++c) {
                    x += s->V[a][c] * s->A[c][b];
                }
                s->VA[a][b] = x;
            }
            for (int b = 0; b < CONTROLS; ++b) {
                double x = 0.0;
                for (int c = 0; c < ERRORS; ++c) {
                    x += s->V[a][c] * s->G[c][b];
                }
                s->VG[a][b] = x;
            }
        }
        double Qu[CONTROLS], Quu[CONTROLS][CONTROLS], Qux[CONTROLS][ERRORS], Qx[ERRORS];
        for (int a = 0; a < CONTROLS; ++a) {
            Qu[a] = 2.0 * WEIGHT_CONTROL * h * u[a];
            for (int c = 0; c < ERRORS; ++c) {
                Qu[a] += s->G[c][a] * v[c];
            }
            for (int b = 0; b < CONTROLS; ++b) {
                double x = a == b ? 2.0 * WEIGHT_CONTROL * h : 0.0;
                for (int c = 0; c < ERRORS; ++c) {
                    x += s->G[c][a] * s->VG[c][b];
                }
                Quu[a][b] = x;
            }
            for (int b = 0; b < ERRORS; ++b) {
                double x = 0.0;
                for (int c = 0; c < ERRORS; ++c) {
                    x += s->G[c][a] * s->VA[c][b];
                }
                Qux[a][b] = x;
            }
        }
        double low[CONTROLS], high[CONTROLS];
        bool free[CONTROLS];
        for (int a = 0; a < CONTROLS; ++a) {
            low[a] = -1.0 - u[a];
            high[a] = 1.0 - u[a];
        }
        const double l = w->x[at][i].l;
        low[3] = smaller(larger(low[3], wheel_within(model, l, -1.0, h) - u[3]), 0.0);
        high[3] = larger(smaller(high[3], wheel_within(model, l, 1.0, h) - u[3]), 0.0);
        double *k = w->k[i];
        memset(k, 0, sizeof w->k[i]);
        box_qp((const double(*)[CONTROLS])Quu, Qu, low, high, 6, k, free);
        for (int a = 0; a < CONTROLS; ++a) {
            for (int b = 0; b < ERRORS; ++b) {
                w->K[i][a][b] = -Qux[a][b];
            }
        }
        solve_free((const double(*)[CONTROLS])Quu, free, ERRORS, &w->K[i][0][0]);

        /* V = Qxx + K'Quu K + K'Qux + Qux'K, v = Qx + K'Quu k + K'Qu + Qux'k */
        double QuuK[CONTROLS][ERRORS], Quuk[CONTROLS];
        for (int a = 0; a < CONTROLS; ++a) {
            Quuk[a] = Qu[a];
            for (int b = 0; b < CONTROLS; ++b) {
                Quuk[a] += Quu[a][b] * k[b];
            }
            for (int b = 0; b < ERRORS; ++b) {
                double x = Qux[a][b];
                for (int c = 0; c < CONTROLS; ++c) {
                    x += Quu[a][c] * w->K[i][c][b];
                }
                QuuK[a][b] = x;
            }
        }
        for (int a = 0; a < ERRORS; ++a) {
            Qx[a] = gradient[a];
            for (int c = 0; c < ERRORS; ++c) {
                Qx[a] += s->A[c][a] * v[c];
            }
            for (int c = 0; c < CONTROLS; ++c) {
                Qx[a] += w->K[i][c][a] * Quuk[c] + Qux[c][a] * k[c];
            }
            for (int b = a; b < ERRORS; ++b) {
                double x = a == b ? diagonal[a] : 0.0;
                for (int c = 0; c < ERRORS; ++c) {
                    x += s->A[c][a] * s->VA[c][b];
                }
                for (int c = 0; c < CONTROLS; ++c) {
                    x += w->K[i][c][a] * QuuK[c][b] + Qux[c][a] * w->K[i][c][b];
                }
                s->next[a][b] = s->next[b][a] = x;
            }
        }
        memcpy(s->V, s->next, sizeof s->V);
        memcpy(v, Qx, sizeof v);
    }
}

int improve(const Model *model, const Motion *x, int iterations, Plan *plan, Workspace *w)
{
    static const double shares[] = {1.0, 0.5, 0.25, 0.1, 0.02};
    int now = 0, used = 0;
    w->x[0][0] = w->x[1][0] = *x;
    memcpy(w->u[0], plan->u, (size_t)plan->stages * sizeof plan->u[0]);
    plan->cost = roll_out(model, plan, w, 0, 0, 0.0);
    while (used < iterations && may_be_flown(plan)) {
        ++used;
        sweep_back(model, plan, w, now);
        double cost = NEVER;
        for (size_t k = 0; k < sizeof shares / sizeof shares[0]; ++k) {
            cost = roll_out(model, plan, w, now, 1 - now, shares[k]);
            if (cost < plan->cost) {
                break;
            }
        }
        if (!(cost < plan->cost)) {
            used = iterations;
            break;
        }
        const bool done = plan->cost - cost < 1e-6 * cost;
        plan->cost = cost;
        now = 1 - now;
        if (done) {
            used = iterations;
        }
    }
    if (may_be_flown(plan)) {
        memcpy(plan->u, w->u[now], (size_t)plan->stages * sizeof plan->u[0]);
    } else {
        used = iterations;
    }
    return used;
}

void plan_at(const Plan *plan, double t, double u[CONTROLS])
{
    double end = plan->start;
    for (int i = 0; i < plan->stages; ++i) {
        end += plan->h[i];
        if (t < end) {
            memcpy(u, plan->u[i], sizeof plan->u[i]);
            return;
        }
    }
    memset(u, 0, sizeof plan->u[0]);
}

static void survey_stage(const Ahead *ahead, int i, double t, double h, Workspace *w)
{
    w->stage[i].around = around_at(ahead, t + 0.5 * h);
    w->stage[i].target = target_at(ahead, t);
}

/* What surrounds the stages that the plan has. */
static void survey(const Ahead *ahead, const Plan *plan, Workspace *w)
{
    double t = plan->start;
    for (int i = 0; i < plan->stages; ++i) {
        survey_stage(ahead, i, t, plan->h[i], w);
        t += plan->h[i];
    }
    w->stage[plan->stages].target = target_at(ahead, t);
}

void lay_stages(const Model *model, const Ahead *ahead, const Motion *x, double t, const Plan *was, Plan *plan, Workspace *w)
{
    Motion now = *x;
    double s = 0.0;
    memset(plan, 0, sizeof *plan); /* to the last byte: plans are part of a saved state */
    plan->start = t;
    while (s < HORIZON - 1e-6) {
        const double whole = s < NEAR - 1e-6 ? STAGE_NEAR : STAGE_FAR;
        const int left = STAGES - plan->stages - (int)((NEAR - smaller(s, NEAR)) / STAGE_NEAR) -
                         (int)((HORIZON - larger(s, NEAR)) / STAGE_FAR) - 1;
        const double speed = norm(now.Omega) * whole / STAGE_NEAR;
        const int wanted = speed > FASTER ? 4 : speed > FAST ? 2 : 1;
        const int parts = left >= 4 ? wanted : 1;
        for (int i = 0; i < parts; ++i) {
            const double h = whole / parts;
            const int k = plan->stages++;
            plan->h[k] = h;
            survey_stage(ahead, k, t + s, h, w);
            double *u = plan->u[k];
            memset(u, 0, sizeof plan->u[0]);
            if (was != NULL) {
                plan_at(was, t + s + 0.5 * h, u);
            }
            now = advanced(model, &w->stage[k].around, &now, u, h);
            s += h;
        }
    }
    w->stage[plan->stages].target = target_at(ahead, t + s);
}

void controls_for(const Model *model, Vector tau, Vector B_B, double l, double u[CONTROLS])
{
    /* |A u - tau|^2 in units of the largest torques, with a little of |u|^2 and of the wheel's rest. */
    Vector A[CONTROLS];
    for (int j = 0; j < 3; ++j) {
        A[j] = cross(model->rods[j], B_B);
    }
    A[3] = (Vector){-model->wheel_torque_max, 0.0, 0.0};
    double H[CONTROLS][CONTROLS], g[CONTROLS];
    const double low[CONTROLS] = {-1.0, -1.0, -1.0, -1.0}, high[CONTROLS] = {1.0, 1.0, 1.0, 1.0};
    bool free[CONTROLS];
    const double rest = larger(smaller(-l / (60.0 * model->wheel_torque_max), 1.0), -1.0);
    for (int i = 0; i < CONTROLS; ++i) {
        const double weight = i < 3 ? 1e-10 : 5e-9;
        for (int j = 0; j < CONTROLS; ++j) {
            H[i][j] = dot(A[i], A[j]) + (i == j ? weight : 0.0);
        }
        g[i] = -dot(A[i], tau) - (i < 3 ? 0.0 : weight * rest);
        u[i] = 0.0;
    }
    box_qp((const double(*)[CONTROLS])H, g, low, high, 12, u, free);
}

/* Controls of a cascade through the limits, to start from: turns to the target at no more than `rate`, rad/s. */
static void cascade(const Model *model, const Motion *x, double rate, Plan *plan, Workspace *w)
{
    Motion now = *x;
    for (int i = 0; i < plan->stages; ++i) {
        const double stiffness = smaller(0.02, 0.2 / plan->h[i]), damping = smaller(0.05, 0.5 / plan->h[i]); /* 1/s */
        const Stage *stage = &w->stage[i];
        const Matrix Q = multiply(transposed(stage->target.R), now.R);
        const Vector zeta = rotation_log(Q);
        const double size = norm(zeta);
        const double speed = smaller(stiffness * size, rate);
        const Vector wanted = subtract(apply_transposed(Q, stage->target.Omega), scale(size > 1e-9 ? speed / size : 0.0, zeta));
        Vector tau = scale(-damping, apply(model->J, subtract(now.Omega, wanted)));
        Vector Pi = apply(model->J, now.Omega);
        Pi.x += now.l;
        tau = subtract(tau, cross(Pi, now.Omega));
        controls_for(model, tau, apply_transposed(now.R, stage->around.B_N), now.l, plan->u[i]);
        now = advanced(model, &stage->around, &now, plan->u[i], plan->h[i]);
    }
}

void search_begin(const Motion *x, double t, Search *search)
{
    search->active = true;
    search->ready = false;
    search->start = 0;
    search->left = ITERATIONS_COLD;
    search->x = *x;
    search->t = t;
}

void search_on(const Model *model, const Ahead *ahead, int iterations, Search *search, Workspace *w)
{
    while (search->active && iterations > 0) {
        if (search->left == ITERATIONS_COLD) {
            lay_stages(model, ahead, &search->x, search->t, NULL, &search->trial, w);
            if (search->start > 0) {
                cascade(model, &search->x, CASCADE_RATES[search->start - 1], &search->trial, w);
            }
        } else {
            survey(ahead, &search->trial, w);
        }
        const int wanted = search->left < iterations ? search->left : iterations;
        const int used = improve(model, &search->x, wanted, &search->trial, w);
        search->left -= used;
        iterations -= used;
        if (search->left == 0) {
            if (search->start == 0 || search->trial.cost < search->best.cost) {
                memcpy(&search->best, &search->trial, sizeof search->best);
            }
            search->left = ITERATIONS_COLD;
            if (++search->start == STARTS) {
                search->active = false;
                search->ready = may_be_flown(&search->best);
            }
        }
    }
}
