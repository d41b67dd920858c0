/* The covariance of the Kalman filter: over a sample, and by a measurement. docs/how/planned-estimates.md,
 * Estimates. Tests: test_identification.py. */
#include <string.h>

#include "identification.h"
#include "rotation.h"

static const double TURN_SHARE = 0.003; /* of the change of rate by turning: the model's error */
static const double RODS_SHARE = 0.03;  /* of that by the rods */

/* Of the states those that a measurement shows: motion and bias. */
enum { MEASURED = MOTION + INERTIA };

static void put_column(double G[MOTION][FILTER_STATES], int column, Vector v)
{
    G[RATE_STATE][column] = v.x;
    G[RATE_STATE + 1][column] = v.y;
    G[RATE_STATE + 2][column] = v.z;
}

static void put_rows(double G[MOTION][FILTER_STATES], int row, int column, Matrix m)
{
    store(m.a, &G[row][column]);
    store(m.b, &G[row + 1][column]);
    store(m.c, &G[row + 2][column]);
}

/* Columns of v -> J v in the six elements of J. */
static void columns_of(Vector v, Vector columns[6])
{
    columns[0] = (Vector){v.x, 0.0, 0.0};
    columns[1] = (Vector){0.0, v.y, 0.0};
    columns[2] = (Vector){0.0, 0.0, v.z};
    columns[3] = (Vector){0.0, v.z, v.y};
    columns[4] = (Vector){v.z, 0.0, v.x};
    columns[5] = (Vector){v.y, v.x, 0.0};
}

/* The derivative of turn and rate at the sample's end by all errors at its beginning. */
static void sensitivity(const Passed *s, Identification *id, double G[MOTION][FILTER_STATES])
{
    const Model *model = s->model;
    const double dt = s->dt;
    const Vector Omega = scale(0.5, add(s->before.Omega, s->after.Omega));
    const Vector change = subtract(s->after.Omega, s->before.Omega);
    id->watch.rate = norm(Omega);
    const Vector Pi = momentum_of(model, &(Motion){.Omega = Omega, .l = 0.5 * (s->before.l + s->after.l)});
    const Vector rho = apply_transposed(s->before.R, s->around->r_hat_N);
    const Matrix scaled = times(dt, model->J_inverse);
    const Matrix gyroscopic = multiply(scaled, sum(hat(Pi), times(-1.0, multiply(hat(Omega), model->J))));
    memset(G, 0, MOTION * sizeof G[0]);
    put_rows(G, 0, 0, transposed(rotation_exp(scale(dt, Omega))));
    put_rows(G, RATE_STATE, RATE_STATE, gyroscopic);
    for (int i = 0; i < 3; ++i) {
        G[i][RATE_STATE + i] = dt;
        G[RATE_STATE + i][RATE_STATE + i] += 1.0;
        id->watch.effect[i] = apply(scaled, cross(s->rods[i], s->B_B));
        put_column(G, MOTION + GAINS + i, id->watch.effect[i]);
    }
    Vector by_change[6], by_rate[6], by_radius[6];
    columns_of(change, by_change);
    columns_of(Omega, by_rate);
    columns_of(rho, by_radius);
    for (int i = 0; i < 6 && id->spread > 0.0; ++i) {
        const Vector gravity = scale(3.0 * s->around->rate_squared, cross(rho, by_radius[i]));
        const Vector torque = subtract(subtract(gravity, cross(Omega, by_rate[i])), scale(1.0 / dt, by_change[i]));
        put_column(G, MOTION + INERTIA + i, apply(scaled, torque));
    }
    put_rows(G, RATE_STATE, MOTION + TORQUE, scaled);
    put_rows(G, RATE_STATE, MOTION + DIPOLE, multiply(scaled, hat(scale(-1.0, s->B_B))));
}

/* rad2/s2: what the model's error may add to each rate over the sample. */
static double model_variance(const Passed *s, const Identification *id)
{
    Vector rods = {0.0, 0.0, 0.0};
    for (int i = 0; i < 3; ++i) {
        rods = add(rods, scale(id->p[GAINS + i], s->rods[i]));
    }
    const double by_rods = RODS_SHARE * norm(apply(s->model->J_inverse, cross(rods, s->B_B)));
    const double by_turning =
        TURN_SHARE * norm(apply(s->model->J_inverse, cross(momentum_of(s->model, &s->before), s->before.Omega)));
    const double density = id->rate_density + id->lasts * (by_rods * by_rods + by_turning * by_turning);
    return id->excess[2] * density * s->dt;
}

/* Of row i of G and a column: only what is not zero in G. */
static double product(double G[MOTION][FILTER_STATES], int i, const double column[FILTER_STATES])
{
    double sum = 0.0;
    for (int k = i < RATE_STATE ? 0 : RATE_STATE; k < MOTION; ++k) {
        sum += G[i][k] * column[k];
    }
    for (int k = MOTION + INERTIA; k < FILTER_STATES && i >= RATE_STATE; ++k) {
        sum += G[i][k] * column[k];
    }
    return sum;
}

/* F P F^T + Q: F is G in the motion's rows, the identity in those of p. */
void controller_planned_propagate(const Passed *passed, Identification *id)
{
    double G[MOTION][FILTER_STATES], GP[MOTION][FILTER_STATES];
    sensitivity(passed, id, G);
    const double dt = passed->dt, variance = model_variance(passed, id);
    for (int i = 0; i < MOTION; ++i) {
        //@ loop unroll FILTER_STATES;
        for (int j = 0; j < FILTER_STATES; ++j) {
            GP[i][j] = product(G, i, id->P[j]);
        }
    }
    for (int i = 0; i < MOTION; ++i) {
        for (int j = i; j < FILTER_STATES; ++j) {
            id->P[i][j] = id->P[j][i] = j < MOTION ? product(G, j, GP[i]) : GP[i][j];
        }
    }
    for (int i = 0; i < 3; ++i) {
        id->P[i][i] += variance * dt * dt / 3.0;
        id->P[i][RATE_STATE + i] += 0.5 * variance * dt;
        id->P[RATE_STATE + i][i] = id->P[i][RATE_STATE + i];
        id->P[RATE_STATE + i][RATE_STATE + i] += variance;
        id->P[MOTION + BIAS + i][MOTION + BIAS + i] += id->excess[2] * id->bias_density * dt;
        id->P[MOTION + TORQUE + i][MOTION + TORQUE + i] += id->torque_density * dt;
    }
}

/* The correction by element i of the innovation: of the turn alone, or of rate and bias together. Of P the upper
 * half. */
static void correct(int i, const double innovation[MOTION], double correction[FILTER_STATES],
                    double gain[MEASURED][MOTION], Identification *id)
{
    double column[FILTER_STATES], left[MOTION];
    const int other = MOTION + BIAS + i - RATE_STATE;
    const double both = i < RATE_STATE ? 0.0 : 1.0;
    //@ loop unroll FILTER_STATES;
    for (int j = 0; j < FILTER_STATES; ++j) {
        column[j] = j < i ? id->P[j][i] : id->P[i][j];
    }
    for (int j = 0; j < FILTER_STATES && i >= RATE_STATE; ++j) {
        column[j] += j < other ? id->P[j][other] : id->P[other][j];
    }
    const double variance = id->variance[i / RATE_STATE] * id->excess[i / RATE_STATE];
    const double inverse_spread = 1.0 / (variance + column[i] + both * column[other]);
    const double error = innovation[i] - correction[i] - both * correction[other];
    for (int j = 0; j < MOTION; ++j) {
        left[j] = (i == j) - gain[i][j] - both * gain[other][j];
    }
    for (int j = 0; j < FILTER_STATES; ++j) {
        const double factor = column[j] * inverse_spread;
        correction[j] += factor * error;
        for (int k = 0; k < MOTION && j < MEASURED; ++k) {
            gain[j][k] += factor * left[k];
        }
        for (int k = j; k < FILTER_STATES; ++k) {
            id->P[j][k] -= factor * column[k];
        }
    }
}

void controller_planned_correct(const double innovation[MOTION], Identification *id)
{
    double correction[FILTER_STATES] = {0.0}, gain[MEASURED][MOTION];
    const int first = id->estimated ? RATE_STATE : 0; /* an estimated attitude is not corrected */
    memset(gain, 0, sizeof gain);
    if (id->estimated) {
        controller_planned_take_attitude(id);
    }
    for (int i = first; i < MOTION; ++i) {
        correct(i, innovation, correction, gain, id);
    }
    for (int i = 0; i < FILTER_STATES; ++i) {
        for (int j = 0; j < i; ++j) {
            id->P[i][j] = id->P[j][i];
        }
    }
    for (int i = first; i < MOTION; ++i) {
        memcpy(id->gain[i], gain[i], sizeof gain[i]);
    }
    for (int i = 0; i < UNKNOWNS; ++i) {
        id->p[i] += correction[MOTION + i];
    }
}
