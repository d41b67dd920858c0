/* Lefferts, Markley and Shuster, JGCD 5 (1982); Markley and Crassidis, Fundamentals of Spacecraft Attitude
 * Determination and Control, chapter 6. Requirement: ES-2. Tests: tests/native/test_flavours.py. */
#include "filter.h"

#include <string.h>

#include "rotation.h"

void estimator_covariance_at_start(double attitude, double rate, double bias, Covariance *P)
{
    const double sigmas[] = {attitude, rate, bias};
    memset(P, 0, sizeof *P);
    for (int i = 0; i < ERROR_STATES; ++i) {
        P->m[i][i] = sigmas[i / 3] * sigmas[i / 3];
    }
}

static void symmetrise(int n, double P[])
{
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < i; ++j) {
            P[n * i + j] = P[n * j + i] = 0.5 * (P[n * i + j] + P[n * j + i]);
        }
    }
}

static const Matrix ZERO = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};

/* The block of P at (i, j), and its place taken by another. */
static Matrix block(const Covariance *P, int i, int j)
{
    return (Matrix){vector(&P->m[i][j]), vector(&P->m[i + 1][j]), vector(&P->m[i + 2][j])};
}

static void set_block(Matrix M, int i, int j, Covariance *P)
{
    store(M.a, &P->m[i][j]);
    store(M.b, &P->m[i + 1][j]);
    store(M.c, &P->m[i + 2][j]);
}

Transition estimator_propagate(Vector turn, double h, double sign, Matrix F, const Walks *walks, Covariance *P)
{
    const Matrix growth = add_scaled(ZERO, h, F), skew = hat(turn);
    const Matrix jacobian = add_scaled(add_scaled(identity, -0.5, skew), 1.0 / 6.0, multiply(skew, skew));
    const Matrix A = transposed(rotation_exp(turn));
    const Matrix B = add_scaled(ZERO, sign * h, multiply(jacobian, add_scaled(identity, 0.5, growth)));
    const Matrix C = add_scaled(add_scaled(identity, 1.0, growth), 0.5, multiply(growth, growth));
    const Matrix D = walks->by_torque ? add_scaled(ZERO, h, walks->push) : ZERO;
    const double lasts = walks->by_torque ? walks->lasts : 1.0;
    /* P <- T P T^T with T = [[A, B, 0], [0, C, D], [0, 0, lasts]]: first the rows, then the columns. */
    Covariance M = *P;
    for (int j = 0; j < ERROR_STATES; j += 3) {
        set_block(add_scaled(multiply(A, block(P, ERROR_ATTITUDE, j)), 1.0, multiply(B, block(P, ERROR_RATE, j))),
                  ERROR_ATTITUDE, j, &M);
        Matrix rate = multiply(C, block(P, ERROR_RATE, j));
        if (walks->by_torque) {
            const Matrix torque = block(P, ERROR_BIAS, j);
            rate = add_scaled(rate, 1.0, multiply(D, torque));
            set_block(add_scaled(ZERO, lasts, torque), ERROR_BIAS, j, &M);
        }
        set_block(rate, ERROR_RATE, j, &M);
    }
    *P = M;
    for (int i = 0; i < ERROR_STATES; i += 3) {
        const Matrix left = block(&M, i, ERROR_ATTITUDE), right = block(&M, i, ERROR_RATE);
        set_block(add_scaled(multiply(left, transposed(A)), 1.0, multiply(right, transposed(B))), i, ERROR_ATTITUDE, P);
        Matrix rate = multiply(right, transposed(C));
        if (walks->by_torque) {
            const Matrix torque = block(&M, i, ERROR_BIAS);
            rate = add_scaled(rate, 1.0, multiply(torque, transposed(D)));
            set_block(add_scaled(ZERO, lasts, torque), i, ERROR_BIAS, P);
        }
        set_block(rate, i, ERROR_RATE, P);
    }
    set_block(add_scaled(add_scaled(block(P, ERROR_ATTITUDE, ERROR_ATTITUDE), h * walks->angle, identity),
                         h * h * h / 3.0, walks->rate),
              ERROR_ATTITUDE, ERROR_ATTITUDE, P);
    set_block(add_scaled(block(P, ERROR_ATTITUDE, ERROR_RATE), sign * 0.5 * h * h, walks->rate), ERROR_ATTITUDE,
              ERROR_RATE, P);
    set_block(add_scaled(block(P, ERROR_RATE, ERROR_ATTITUDE), sign * 0.5 * h * h, walks->rate), ERROR_RATE,
              ERROR_ATTITUDE, P);
    set_block(add_scaled(block(P, ERROR_RATE, ERROR_RATE), h, walks->rate), ERROR_RATE, ERROR_RATE, P);
    set_block(add_scaled(block(P, ERROR_BIAS, ERROR_BIAS), h * walks->bias, identity), ERROR_BIAS, ERROR_BIAS, P);
    symmetrise(ERROR_STATES, P->m[0]);
    return (Transition){A, B, C, D, lasts};
}

/* One component: y = row . error + noise of variance r. */
static void correct_by(double y, const double row[], double r, int n, double P[], int component, LongCorrection *given)
{
    double PH[ERROR_STATES_MAX], s = r, left = y, *K = given->gains[component];
    for (int i = 0; i < n; ++i) {
        PH[i] = 0.0;
        for (int j = 0; j < n; ++j) {
            PH[i] += P[n * i + j] * row[j];
        }
        s += row[i] * PH[i];
        left -= row[i] * given->error[i];
    }
    for (int i = 0; i < n; ++i) {
        K[i] = PH[i] / s;
        given->error[i] += left * K[i];
    }
    for (int i = 0; i < n; ++i) {
        double MH = 0.0;
        for (int j = 0; j < n; ++j) {
            P[n * i + j] -= K[i] * PH[j];
            MH += P[n * i + j] * row[j];
        }
        for (int j = 0; j < n; ++j) {
            P[n * i + j] += (r * K[i] - MH) * K[j];
        }
    }
    symmetrise(n, P);
    given->residual[component] = left;
    given->variance[component] = s;
}

double estimator_correct_states(const Innovation *innovation, int states, double P[], LongCorrection *given)
{
    double y[3], r[3], H[3][3], nis = 0.0;
    store(innovation->y, y);
    store(innovation->r, r);
    store_matrix(innovation->H_attitude, H);
    memset(given->error, 0, sizeof given->error);
    for (int i = 0; i < 3; ++i) {
        double row[ERROR_STATES_MAX] = {H[i][0], H[i][1], H[i][2]};
        row[ERROR_BIAS + i] = innovation->biased ? 1.0 : 0.0;
        correct_by(y[i], row, r[i], states, P, i, given);
        nis += given->residual[i] * given->residual[i] / given->variance[i];
    }
    return nis;
}

double estimator_correct(const Innovation *innovation, Covariance *P, Correction *given)
{
    LongCorrection all;
    const double nis = estimator_correct_states(innovation, ERROR_STATES, P->m[0], &all);
    (void)memcpy(given->error, all.error, sizeof given->error);
    for (int i = 0; i < 3; ++i) {
        (void)memcpy(given->gains[i], all.gains[i], sizeof given->gains[i]);
        given->scaled[i] = all.residual[i] / sqrt(all.variance[i] + innovation->lasting * innovation->lasting);
    }
    return nis;
}
