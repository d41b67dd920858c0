/* What the Kalman filter learns, what it believes, and when it does not. */
#include "identification.h"

#include <string.h>

#include "rotation.h"

static const double EXPECTED = 0.25;       /* of a largest value: its standard deviation before the flight */
static const double EXPECTED_DIPOLE = 0.4; /* the same of the residual dipole */
static const double PRODUCTS = 0.5;        /* of the moments' deviation: that of the products of inertia */
static const double BIAS_TIME = 1e5;       /* s, in which the bias of the rate may become another */
static const double TRUST = 0.4;           /* largest change of inertia and gains, relative */
static const double REST_NOISE = 2.5e-4;   /* 1/T, standard deviation of the rate after T at rest, by the model's error */
static const double LASTS = 0.5;           /* T, for which the model's error stays alike */
static const double GATE = 6.0;            /* standard deviations of an innovation that is believed */
static const double EXCESS_TIME = 2.0;     /* T, over which innovations are averaged */
static const double ALIKE = 0.2;           /* mean cosine of innovations in turn, above which the model is the cause */
static const double EXCESS_MAX = 1e6;
static const double EVIDENCE_MAX = 25.0; /* beyond which the start is taken again */

enum { HALVINGS = 4 }; /* of what is estimated less the start, until it is the inertia of a body */

/* `count` unknowns become independent of all others. */
static void forget(Identification *id, int first, int count, double deviation)
{
    for (int i = MOTION + first; i < MOTION + first + count; ++i) {
        for (int j = 0; j < FILTER_STATES; ++j) {
            id->P[i][j] = id->P[j][i] = 0.0;
        }
        id->P[i][i] = deviation * deviation;
    }
}

static void begin_properties(Identification *id)
{
    memcpy(id->p + INERTIA, id->start + INERTIA, (TORQUE - INERTIA) * sizeof id->p[0]);
    for (int i = 0; i < 6; ++i) {
        forget(id, INERTIA + i, 1, id->inertia_spread[i]);
    }
    forget(id, GAINS, 3, id->spread);
    id->evidence = 0.0;
}

/* Attitude and rate are those that were measured; the rate's error is then that of noise and bias. */
static void take_measured(Identification *id)
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < FILTER_STATES; ++j) {
            id->P[i][j] = id->P[j][i] = 0.0;
        }
        for (int j = MOTION; j < FILTER_STATES; ++j) {
            id->P[RATE_STATE + i][j] = id->P[j][RATE_STATE + i] = -id->P[MOTION + BIAS + i][j];
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            id->P[RATE_STATE + i][RATE_STATE + j] = id->P[MOTION + BIAS + i][MOTION + BIAS + j];
        }
    }
    for (int i = 0; i < MOTION; ++i) {
        id->P[i][i] += id->variance[i / RATE_STATE] * id->excess[i / RATE_STATE];
        for (int j = 0; j < MOTION; ++j) {
            id->gain[i][j] = i == j;
        }
    }
}

Matrix controller_planned_sigma_before(const ControllerPlannedParameters *p)
{
    const Matrix J = matrix(p->J_B);
    const double spread = p->identify ? p->identify_spread : 0.0;
    const double product = PRODUCTS * spread * (J.a.x + J.b.y + J.c.z) / 3.0;
    return (Matrix){{spread * J.a.x, product, product}, {product, spread * J.b.y, product}, {product, product, spread * J.c.z}};
}

/* The six elements of a symmetric matrix, in the order of p. */
static void store_symmetric(Matrix m, double p[6])
{
    const double elements[6] = {m.a.x, m.b.y, m.c.z, m.b.z, m.c.x, m.a.y};
    memcpy(p, elements, sizeof elements);
}

static Matrix symmetric(const double p[6])
{
    return (Matrix){{p[0], p[5], p[4]}, {p[5], p[1], p[3]}, {p[4], p[3], p[2]}};
}

void controller_planned_identification_start(const ControllerPlannedParameters *p, const Scales *scales, Identification *id)
{
    const double T = scales->time, inertia = scales->momentum * T;
    memset(id, 0, sizeof *id);
    store_symmetric(matrix(p->J_B), id->start + INERTIA);
    store_symmetric(controller_planned_sigma_before(p), id->inertia_spread);
    store((Vector){1.0, 1.0, 1.0}, id->start + GAINS);
    id->spread = p->identify ? p->identify_spread : 0.0;
    id->limit[0] = p->rate_bias_max;
    id->limit[1] = scales->disturbance_max;
    id->limit[2] = scales->residual_dipole_max;
    id->limit[3] = PRODUCTS * TRUST * inertia;
    id->variance[0] = p->attitude_noise * p->attitude_noise;
    id->variance[1] = p->rate_noise * p->rate_noise;
    id->rate_density = REST_NOISE * REST_NOISE / (T * T * T);
    id->bias_density = EXPECTED * EXPECTED * id->limit[0] * id->limit[0] / BIAS_TIME;
    /* The filter at rest then forgets over disturbance_time. */
    id->torque_density =
        id->limit[1] > 0.0 ? id->rate_density * inertia * inertia / (p->disturbance_time * p->disturbance_time) : 0.0;
    id->lasts = LASTS * T;
    id->forgets = EXCESS_TIME * T;
    id->excess[0] = id->excess[1] = id->excess[2] = 1.0;
    begin_properties(id);
    forget(id, BIAS, 3, EXPECTED * id->limit[0]);
    forget(id, TORQUE, 3, EXPECTED * id->limit[1]);
    forget(id, DIPOLE, 3, EXPECTED_DIPOLE * id->limit[2]);
    take_measured(id);
}

Matrix controller_planned_estimated_inertia(const Identification *id)
{
    Matrix J = symmetric(id->p + INERTIA);
    const Matrix start = symmetric(id->start + INERTIA);
    Fault unused;
    for (int i = 0; i < HALVINGS && !is_inertia(J, "", &unused); ++i) {
        J = i < HALVINGS - 1 ? times(0.5, sum(J, start)) : start;
    }
    return J;
}

Matrix controller_planned_inertia_sigma(const Identification *id)
{
    double sigma[6];
    for (int i = 0; i < 6; ++i) {
        sigma[i] = sqrt(larger(id->P[MOTION + INERTIA + i][MOTION + INERTIA + i], 0.0));
    }
    return symmetric(sigma);
}

double controller_planned_rods_gain(const Identification *id)
{
    return (id->p[GAINS] + id->p[GAINS + 1] + id->p[GAINS + 2]) / 3.0;
}

static void keep_within(double v[3], double limit)
{
    const double size = norm(vector(v));
    for (int i = 0; i < 3 && size > limit; ++i) {
        v[i] *= limit / size;
    }
}

static void keep_all_within(Identification *id)
{
    for (int i = INERTIA; i < TORQUE; ++i) {
        const bool product = i >= INERTIA + 3 && i < GAINS;
        const double room = product ? id->limit[3] : TRUST * id->start[i];
        id->p[i] = clip(id->p[i], id->start[i] - room, id->start[i] + room);
    }
    keep_within(id->p + BIAS, id->limit[0]);
    keep_within(id->p + TORQUE, id->limit[1]);
    keep_within(id->p + DIPOLE, id->limit[2]);
}

/* Variances that are too small for the mean squares of the innovations grow, and shrink again: of two innovations in turn that are
 * alike the model is the cause, of others the noise of what is measured. */
static void widen(double dt, const double square[2], const Vector innovation[2], Identification *id)
{
    const double share = smaller(dt / id->forgets, 1.0);
    double of_model = 0.0;
    for (int kind = 0; kind < 2; ++kind) {
        const double sizes = norm(innovation[kind]) * norm(id->last[kind]), growth = 1.0 + (square[kind] - 1.0) * share;
        if (sizes > 0.0 && isfinite(sizes)) {
            id->alike[kind] += share * (dot(innovation[kind], id->last[kind]) / sizes - id->alike[kind]);
        }
        id->last[kind] = innovation[kind];
        const bool model = id->alike[kind] > ALIKE;
        id->excess[kind] = clip(id->excess[kind] * (model ? smaller(growth, 1.0 - share) : growth), 1.0, EXCESS_MAX);
        of_model = larger(of_model, model ? growth : smaller(growth, 1.0));
    }
    id->excess[2] = clip(id->excess[2] * of_model, 1.0, EXCESS_MAX);
}

/* Whether the innovations fit their variances, or the measurement is exact; how far they do is averaged. */
static bool is_believed(double dt, const double innovation[MOTION], Identification *id)
{
    double square[2] = {0.0, 0.0};
    bool believed = true;
    for (int i = 0; i < MOTION; ++i) {
        const int kind = i / RATE_STATE, b = MOTION + BIAS + i - RATE_STATE;
        const double spread =
            id->variance[kind] * id->excess[kind] + id->P[i][i] + (kind == 1 ? 2.0 * id->P[i][b] + id->P[b][b] : 0.0);
        const double ratio = innovation[i] * innovation[i] / spread;
        believed = believed && (ratio <= GATE * GATE || id->variance[kind] == 0.0);
        square[kind] += (ratio <= GATE * GATE ? ratio : GATE * GATE) / 3.0;
    }
    const Vector both[2] = {vector(innovation), vector(innovation + RATE_STATE)};
    widen(dt, square, both, id);
    return believed;
}

void controller_planned_learn(double dt, Vector turn, Vector rate, Vector nominal, Identification *id)
{
    double innovation[MOTION];
    store(turn, innovation);
    store(rate, innovation + RATE_STATE);
    id->bias = vector(id->p + BIAS);
    if (!is_believed(dt, innovation, id)) {
        id->rejected += id->rejected < 2;
        memset(id->gain, 0, sizeof id->gain);
        if (id->rejected > 1) {
            take_measured(id); /* twice in turn: it is the prediction that is wrong */
        }
        return;
    }
    id->rejected = 0;
    const double expected = id->P[RATE_STATE][RATE_STATE] + id->variance[1] * id->excess[1];
    id->evidence = larger(id->evidence + 0.5 * (dot(rate, rate) - dot(nominal, nominal)) / expected, 0.0);
    controller_planned_correct(innovation, id);
    keep_all_within(id);
    if (id->evidence > EVIDENCE_MAX) {
        begin_properties(id);
    }
}
