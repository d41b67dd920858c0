/* docs/how/planned-plan.md, Steering.
 *
 * H = R (J Omega + l e1) follows dH/dt = m x B(t) whatever the attitude is. With |m| <= rho the quickest way has
 * m = rho unit(B x lambda) with constant lambda, so D = rho int (|B|^2 I - B B^T)/|B x lambda| ds lambda.
 * Tests: test_steering.py. */
#include "steering.h"

static const double SPACING = 0.4; /* T between nodes of the field ahead; in the last of it the dipole is lessened */
static const double ALIGNED_MIN = 0.03; /* |B x lambda| counts at least as this share of |B| */
static const double EXACT = 1.2;        /* T before the end from which the direction is kept exactly */
static const double ALIGNED_FULL = 0.2; /* cosine of a rod to the wanted dipole from which it is at its limit */
static const double TINY = 1e-300;      /* keeps a length of zero from dividing */
enum { ITERATIONS = 5, HALVINGS = 12 };

static Matrix across(Vector B, Vector lambda)
{
    const double weight = 1.0 / larger(norm(cross(B, lambda)), ALIGNED_MIN * norm(B));
    const double d = weight * dot(B, B);
    return (Matrix){{d - weight * B.x * B.x, -weight * B.x * B.y, -weight * B.x * B.z},
                    {-weight * B.y * B.x, d - weight * B.y * B.y, -weight * B.y * B.z},
                    {-weight * B.z * B.x, -weight * B.z * B.y, d - weight * B.z * B.z}};
}

/* The least time in which dipoles across lambda give D_N, s, and ell = M^-1 D_N at its end, of the length of the
 * dipole. */
static double least_time(const Vector field[STEERING_NODES], Vector lambda, Vector D_N, double dipole, double spacing,
                         Vector *ell)
{
    Matrix M = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}, before = M, last = across(field[0], lambda);
    int i = 1;
    for (*ell = D_N; i < STEERING_NODES; ++i) {
        const Matrix here = across(field[i], lambda);
        before = M;
        M = add_scaled(add_scaled(M, 0.5 * spacing, last), 0.5 * spacing, here);
        last = here;
        *ell = solve(M, D_N);
        if (norm(*ell) <= dipole) {
            break;
        }
    }
    if (i == STEERING_NODES) {
        return spacing * (STEERING_NODES - 1);
    }
    /* The instant within the last interval, by halving; before the first node all is proportional. */
    double low = 0.0, high = 1.0;
    for (int k = 0; k < HALVINGS; ++k) {
        const double share = 0.5 * (low + high);
        const Vector trial = solve(add_scaled(add_scaled(before, -share, before), share, M), D_N);
        if (norm(trial) <= dipole) {
            high = share;
            *ell = trial;
        } else {
            low = share;
        }
    }
    return spacing * (i - 1 + high);
}

void controller_planned_steer(const Ahead *ahead, double t, Vector D_N, double dipole, double unit,
                              Vector field[STEERING_NODES], Steering *steering)
{
    const double needed = norm(D_N);
    if (!(needed > 0.0)) {
        return;
    }
    for (int i = 0; i < STEERING_NODES; ++i) {
        field[i] = controller_planned_around_at(ahead, t + SPACING * unit * i).B_N;
    }
    Vector lambda = norm(steering->lambda_N) > 0.0 ? steering->lambda_N : scale(1.0 / needed, D_N), ell;
    double time = 0.0;
    for (int iteration = 0; iteration < ITERATIONS; ++iteration) {
        time = least_time(field, lambda, D_N, dipole, SPACING * unit, &ell);
        if (!(norm(ell) > 0.0 && is_finite(ell))) {
            return; /* a field whose direction does not change gives nothing along it */
        }
        lambda = scale(1.0 / norm(ell), ell);
    }
    steering->lambda_N = lambda;
    steering->time = time;
}

void controller_planned_steering_rods(const Steering *steering, Matrix R, Vector B_B, const Vector rods[3], double unit,
                                      double u[3])
{
    const Vector w = cross(B_B, apply_transposed(R, steering->lambda_N));
    if (steering->time > EXACT * unit) {
        /* What gives most along lambda: each rod at its limit, smoothly where it changes sign. What it gives besides
         * averages out as the satellite turns. */
        for (int i = 0; i < 3; ++i) {
            const double along = dot(rods[i], w) / larger(norm(rods[i]) * norm(w), TINY);
            u[i] = clip(along / ALIGNED_FULL, -1.0, 1.0);
        }
        return;
    }
    /* Shares of the rods' limits that give w, and B: columns `rods` times the shares. */
    const Matrix axes = transposed((Matrix){rods[0], rods[1], rods[2]});
    double p[3], q[3];
    store(solve(axes, w), p);
    store(solve(axes, B_B), q);
    /* The part along B gives no torque: of the beta where two rods give alike, that of the least greatest share. */
    double best = larger(larger(fabs(p[0]), fabs(p[1])), fabs(p[2])), beta = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const int j = (i + 1) % 3;
            const double slope = q[i] - sign * q[j];
            if (slope == 0.0) {
                continue;
            }
            const double trial = -(p[i] - sign * p[j]) / slope;
            double size = 0.0;
            for (int k = 0; k < 3; ++k) {
                size = larger(size, fabs(p[k] + trial * q[k]));
            }
            if (size < best) {
                best = size;
                beta = trial;
            }
        }
    }
    const double factor = best > 0.0 ? smaller(1.0, steering->time / (SPACING * unit)) / best : 0.0;
    for (int i = 0; i < 3; ++i) {
        u[i] = factor * (p[i] + beta * q[i]);
    }
}
