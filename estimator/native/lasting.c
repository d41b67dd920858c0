/* Errors of the sensors that last, and what they make of the estimate: a consider analysis (Schmidt, 1966; Markley and
 * Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, section 12.3.4).
 * Requirement: ES-5. Tests: tests/native/test_flavours.py, tests/estimator/test_bound.py. */
#include <string.h>

#include "state.h"

static const double PI = 3.14159265358979323846;
static const double GROWS = 600.0;             /* s, in which an offset that drifts grows by e */
static const double SURE = 2.5758293035489004; /* a normal number is below it, in magnitude, with 99% */

void estimator_lasting_begin(double off, Estimate *x)
{
    memset(&x->S, 0, sizeof x->S);
    for (int i = 0; i < 3; ++i) {
        x->S.m[ERROR_ATTITUDE + i][LASTING_START + i] = off;
    }
}

static void spread(const EstimatorLaw *law, const Transition *t, double left, Estimate *x)
{
    double A[3][3], B[3][3], C[3][3], D[3][3], omega[3];
    store_matrix(t->attitude, A);
    store_matrix(t->turned, B);
    store_matrix(t->rate, C);
    store_matrix(t->pushed, D);
    const bool by_torque = estimator_gyro_lost(law, x);
    store(subtract(x->rate, x->rate_bias), omega);
    double (*S)[LASTING] = x->S.m;
    for (int k = 0; k < LASTING; ++k) {
        const double a[3] = {S[0][k], S[1][k], S[2][k]}, r[3] = {S[3][k], S[4][k], S[5][k]};
        for (int i = 0; i < 3; ++i) {
            S[ERROR_ATTITUDE + i][k] =
                A[i][0] * a[0] + A[i][1] * a[1] + A[i][2] * a[2] + B[i][0] * r[0] + B[i][1] * r[1] + B[i][2] * r[2];
            S[ERROR_RATE + i][k] = C[i][0] * r[0] + C[i][1] * r[1] + C[i][2] * r[2];
        }
        for (int i = 0; by_torque && i < 3; ++i) {
            S[ERROR_RATE + i][k] += D[i][0] * S[6][k] + D[i][1] * S[7][k] + D[i][2] * S[8][k];
        }
        for (int i = ERROR_BIAS; by_torque && i < ERROR_STATES; ++i) {
            S[i][k] *= t->lasts;
        }
    }
    for (int i = 0; i < ERROR_STATES; ++i) {
        for (int k = LASTING_DRIFT; k < LASTING; ++k) {
            S[i][k] *= left;
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; x->by_gyro && j < 3; ++j) {
            S[ERROR_ATTITUDE + i][LASTING_GYRO + j] += law->p.lasting_rate_scale * B[i][j] * omega[j];
        }
    }
}

void estimator_spread(const EstimatorLaw *law, Vector turn, double sign, Matrix F, Matrix walk, double angle_variance,
                      double h, Estimate *x)
{
    const bool lost = estimator_gyro_lost(law, x);
    const double bias =
        lost ? sqrt(2.0 / ESTIMATOR_LASTS) * estimator_disturbance_sigma(law) : law->p.field_random_walk;
    if (x->tracking && h > 0.0) {
        Walks walks;
        walks.angle = angle_variance;
        walks.bias = bias * bias;
        walks.rate = walk;
        walks.by_torque = lost;
        walks.push = law->J_inverse;
        walks.lasts = exp(-h / ESTIMATOR_LASTS);
        const Transition transition = estimator_propagate(turn, h, sign, F, &walks, &x->P);
        spread(law, &transition, exp(-h / GROWS), x);
    }
}

/* What the errors that last add to the components of an innovation. */
static void additions(const EstimatorParameters *p, int gated, const double H[3][3], double G[3][LASTING])
{
    const double b[3] = {H[2][1], H[0][2], H[1][0]};
    (void)memset(G, 0, 3U * sizeof G[0]);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (gated == GATED_FIELD) {
                G[i][LASTING_SCALE + 3 * i + j] = p->lasting_field_scale * b[j];
            } else if (gated == GATED_SUN) {
                G[i][LASTING_SUN + j] = p->lasting_sun * H[i][j];
            } else {
                G[i][LASTING_TRACKER + j] = p->lasting_attitude * H[i][j];
            }
        }
        G[i][LASTING_OFFSET + i] = G[i][LASTING_DRIFT + i] = gated == GATED_FIELD ? p->lasting_field : 0.0;
    }
}

void estimator_lasting_take(const EstimatorLaw *law, int gated, const Innovation *innovation,
                            const double gains[3][ERROR_STATES], Estimate *x)
{
    double H[3][3], G[3][LASTING];
    store_matrix(innovation->H_attitude, H);
    additions(&law->p, gated, (const double (*)[3])H, G);
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < LASTING; ++k) {
            G[i][k] += H[i][0] * x->S.m[0][k] + H[i][1] * x->S.m[1][k] + H[i][2] * x->S.m[2][k];
            G[i][k] += innovation->biased ? x->S.m[ERROR_BIAS + i][k] : 0.0;
        }
        for (int s = 0; s < ERROR_STATES; ++s) {
            for (int k = 0; k < LASTING; ++k) {
                x->S.m[s][k] -= gains[i][s] * G[i][k];
            }
        }
    }
}

void estimator_lasting_rate(double sign, Estimate *x)
{
    for (int i = ERROR_RATE; i < ERROR_RATE + 3; ++i) {
        for (int k = 0; k < LASTING; ++k) {
            x->S.m[i][k] *= sign;
        }
    }
    (void)memset(x->S.m[ERROR_BIAS], 0, 3U * sizeof x->S.m[0]);
}

double estimator_bound(const EstimatorLaw *law, const Estimate *x, bool doubtful)
{
    if (!x->tracking || doubtful) {
        return PI;
    }
    double square = 0.0;
    for (int i = ERROR_ATTITUDE; i < ERROR_ATTITUDE + 3; ++i) {
        square += x->P.m[i][i];
        for (int k = 0; k < LASTING_DRIFT; ++k) {
            square += x->S.m[i][k] * x->S.m[i][k];
        }
    }
    if (law->p.bank) {
        const double field = law->p.lasting_field / norm(x->b_B) + law->p.lasting_field_scale;
        square += field * field + law->p.lasting_sun * law->p.lasting_sun;
    }
    const double bound = SURE * sqrt(square);
    return bound < PI ? bound : PI;
}
