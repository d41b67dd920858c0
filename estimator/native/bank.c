/* Lefferts, Markley and Shuster, JGCD 5 (1982), with the gyro's scale as a state, many times side by side.
 * Requirement: ES-3. Tests: tests/native/test_flavours.py, tests/estimator/test_banked.py. */
#include "bank.h"

#include <string.h>

static const double PI = 3.14159265358979323846;
static const double PRUNE_MARGIN = 80.0;
static const double PRUNE_COSINE = 0.99862953475457383; /* 3 deg: attitudes that count as one */
static const double ALIKE = 1e-6;                       /* scores that are nearer than this are alike */
static const double MARGIN = 10.0; /* of the log-likelihood: less likely by this is excluded, one in 20,000 */
static const double UNIQUE = 0.17453292519943295; /* 10 deg: the attitude is unique where no other one is farther */
static const double STRAIN_MAX = 5.0;
static const double ACROSS = 0.1; /* rad, standard deviation of the start across the field */

Matrix estimator_axes_about(Vector z)
{
    const double x = fabs(z.x), y = fabs(z.y), least = smaller(smaller(x, y), fabs(z.z));
    const Vector across = x == least ? identity.a : y == least ? identity.b : identity.c;
    const Vector first = cross(across, z), unit = scale(1.0 / norm(first), first);
    return (Matrix){unit, cross(z, unit), z};
}

void estimator_bank_clear(Bank *bank)
{
    bank->count = bank->taken = bank->in_a_row = 0;
    bank->scale = (Vector){0.0, 0.0, 0.0};
    bank->ambiguity = PI;
    bank->strain = 0.0;
}

void estimator_bank_start(Vector b_B, Vector B_N, const BankNoise *noise, Bank *bank)
{
    const Matrix in_B = estimator_axes_about(scale(1.0 / norm(b_B), b_B));
    const Matrix in_N = estimator_axes_about(scale(1.0 / norm(B_N), B_N));
    const double along = PI / (double)BANK_TURNS, z[3] = {in_B.c.x, in_B.c.y, in_B.c.z};
    BankFilter first;
    memset(&first, 0, sizeof first);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            first.P[i][j] = (along * along - ACROSS * ACROSS) * z[i] * z[j] + (i == j ? ACROSS * ACROSS : 0.0);
        }
        first.P[ERROR_RATE + i][ERROR_RATE + i] = noise->bias * noise->bias;
        first.P[ERROR_BIAS + i][ERROR_BIAS + i] = noise->field_bias * noise->field_bias;
        first.P[BANK_SCALE + i][BANK_SCALE + i] = noise->scale * noise->scale;
    }
    for (int turn = 0; turn < BANK_TURNS; ++turn) {
        const Matrix about = rotation_exp((Vector){0.0, 0.0, 2.0 * PI * turn / (double)BANK_TURNS});
        for (int i = 0; i < BANK_SCALES; ++i) {
            const double off = 4.0 * i / (BANK_SCALES - 1) - 2.0; /* deviations */
            BankFilter *filter = &bank->of[turn * BANK_SCALES + i];
            *filter = first;
            filter->R = multiply(transposed(in_N), multiply(about, in_B));
            filter->scale = (Vector){off * noise->scale, off * noise->scale, off * noise->scale};
            filter->score = -0.5 * off * off;
        }
    }
    bank->count = BANK_FILTERS;
    bank->taken = bank->in_a_row = 0;
}

static Vector true_rate(Vector measured, const BankFilter *filter)
{
    const Vector rate = subtract(measured, filter->bias), k = filter->scale;
    return (Vector){rate.x / (1.0 + k.x), rate.y / (1.0 + k.y), rate.z / (1.0 + k.z)};
}

/* rad: the integral of exp(-rate^ (since - t)) change t/since over `since`, in closed form. */
static Vector made_up(Vector rate, Vector change, double since)
{
    if (!(since > 0.0)) {
        return (Vector){0.0, 0.0, 0.0};
    }
    const double angle = larger(norm(rate) * since, 1e-3), w = angle / since;
    const Vector across = cross(rate, change), normal = scale(-1.0 / (w * w), cross(rate, across));
    const double turned = (1.0 - cos(angle)) / (angle * w) - 0.5 * since;
    const Vector turn = add(scale(0.5 * since, change), scale(turned, normal));
    return subtract(turn, scale((1.0 - sin(angle) / angle) / (w * w), across));
}

/* I - (1 - cos a)/a^2 v^ + (a - sin a)/a^3 v^ v^: exp(v + d) is exp(v) exp(this d) to first order in d. */
static Matrix right_jacobian_of_turn(Vector v)
{
    const double a = larger(norm(v), 1e-4);
    const Matrix skew = hat(v);
    return add_scaled(add_scaled(identity, -(1.0 - cos(a)) / (a * a), skew), (a - sin(a)) / (a * a * a),
                      multiply(skew, skew));
}

/* P <- T P T^T with the rows of T[0..2] given and the others those of the identity. */
static void transform(double T[3][BANK_STATES], double P[BANK_STATES][BANK_STATES])
{
    double M[3][BANK_STATES], left[3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < BANK_STATES; ++j) {
            M[i][j] = 0.0;
            for (int k = 0; k < BANK_STATES; ++k) {
                M[i][j] += T[i][k] * P[k][j];
            }
        }
    }
    (void)memcpy(P, M, sizeof M);
    for (int i = 0; i < BANK_STATES; ++i) {
        for (int j = 0; j < 3; ++j) {
            left[j] = 0.0;
            for (int k = 0; k < BANK_STATES; ++k) {
                left[j] += P[i][k] * T[j][k];
            }
        }
        (void)memcpy(P[i], left, sizeof left);
    }
    for (int i = 0; i < BANK_STATES; ++i) {
        for (int j = 0; j < i; ++j) {
            P[i][j] = P[j][i] = 0.5 * (P[i][j] + P[j][i]);
        }
    }
}

void estimator_bank_propagate(Vector now, double h, double since, const BankNoise *noise, Bank *bank)
{
    for (int32_t k = 0; k < bank->count; ++k) {
        BankFilter *filter = &bank->of[k];
        const Vector rate = true_rate(bank->rate, filter), after = true_rate(now, filter);
        const Vector middle = scale(0.5, add(rate, after));
        const Vector more = made_up(rate, subtract(after, rate), since);
        const Matrix step = multiply(rotation_exp(scale(h, rate)), rotation_exp(more));
        const Matrix J = right_jacobian_of_turn(scale(h, middle));
        double T[3][BANK_STATES], A[3][3], B[3][3];
        (void)memset(T, 0, sizeof T);
        store_matrix(transposed(step), A);
        store_matrix(J, B);
        for (int i = 0; i < 3; ++i) {
            const double w[3] = {middle.x, middle.y, middle.z};
            for (int j = 0; j < 3; ++j) {
                T[i][j] = A[i][j];
                T[i][ERROR_RATE + j] = -h * B[i][j];
                T[i][BANK_SCALE + j] = -h * B[i][j] * w[j];
            }
        }
        filter->R = multiply(filter->R, step);
        transform(T, filter->P);
        for (int i = 0; i < 3; ++i) {
            filter->P[i][i] += noise->angle * noise->angle * h;
            filter->P[ERROR_RATE + i][ERROR_RATE + i] += noise->bias_walk * noise->bias_walk * h;
            filter->P[ERROR_BIAS + i][ERROR_BIAS + i] += noise->field_walk * noise->field_walk * h;
        }
    }
}

double estimator_bank_correct(const Innovation *innovation, double gate, BankFilter *filter)
{
    double P[BANK_STATES][BANK_STATES];
    LongCorrection given;
    (void)memcpy(P, filter->P, sizeof P);
    const double nis = estimator_correct_states(innovation, BANK_STATES, P[0], &given), unit = innovation->r.x;
    /* Each variance is that of a component once those before it are known: their product is det S. */
    const double ratio = given.variance[0] / unit * (given.variance[1] / unit) * (given.variance[2] / unit);
    filter->score -= 0.5 * (smaller(nis, gate) + log(ratio));
    if (nis <= gate) {
        (void)memcpy(filter->P, P, sizeof P);
        filter->R = multiply(filter->R, rotation_exp(vector(given.error)));
        filter->bias = add(filter->bias, vector(given.error + ERROR_RATE));
        filter->field_bias = add(filter->field_bias, vector(given.error + ERROR_BIAS));
        filter->scale = add(filter->scale, vector(given.error + BANK_SCALE));
    }
    return nis;
}

/* Of those from the number `first` on the most likely; of those alike the first one, so that both flavours take it. */
static int32_t best_from(int32_t first, const Bank *bank)
{
    double top = bank->of[first].score;
    for (int32_t k = first + 1; k < bank->count; ++k) {
        top = larger(top, bank->of[k].score);
    }
    int32_t best = first;
    while (best < bank->count - 1 && bank->of[best].score < top - ALIKE) {
        ++best;
    }
    return best;
}

int32_t estimator_bank_best(const Bank *bank)
{
    return best_from(0, bank);
}

static double cosine_between(Matrix R, Matrix S)
{
    const double trace = dot(R.a, S.a) + dot(R.b, S.b) + dot(R.c, S.c);
    return 0.5 * (trace - 1.0);
}

/* The filters sorted by falling scores; those that stay are moved to the front as they are chosen. */
void estimator_bank_prune(Bank *bank)
{
    int32_t kept = 0;
    //@ loop unroll BANK_FILTERS;
    for (int32_t i = 0; i < bank->count; ++i) {
        const int32_t next = best_from(i, bank);
        const BankFilter filter = bank->of[next];
        bank->of[next] = bank->of[i];
        bank->of[i] = filter;
        bool stays = i == 0 || filter.score > bank->of[0].score - PRUNE_MARGIN;
        for (int32_t k = 0; k < kept; ++k) {
            stays = stays && cosine_between(bank->of[k].R, filter.R) < PRUNE_COSINE;
        }
        if (stays) {
            bank->of[kept] = filter;
            ++kept;
        }
    }
    bank->count = kept;
    bank->taken = 0;
}

static double largest_part(Vector v, double sigma)
{
    return sigma > 0.0 ? larger(larger(fabs(v.x), fabs(v.y)), fabs(v.z)) / sigma : 0.0;
}

void estimator_bank_look(const BankNoise *noise, Bank *bank)
{
    const BankFilter *best = &bank->of[estimator_bank_best(bank)];
    double farthest = 0.0;
    for (int32_t k = 0; k < bank->count; ++k) {
        if (bank->of[k].score > best->score - MARGIN) {
            farthest = larger(farthest, principal_angle(multiply(transposed(best->R), bank->of[k].R)));
        }
    }
    bank->ambiguity = farthest;
    bank->strain = larger(largest_part(best->bias, noise->bias), largest_part(best->scale, noise->scale));
    bank->scale = best->scale;
}

int32_t estimator_bank_doubtful(const Bank *bank)
{
    if (!(bank->ambiguity < UNIQUE)) {
        return 1;
    }
    return bank->strain <= STRAIN_MAX ? 0 : 2;
}
