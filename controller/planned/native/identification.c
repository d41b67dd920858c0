#include "identification.h"

#include <string.h>

#include "rotation.h"

static const double EXPECTED = 0.25;       /* of a largest value: its standard deviation before the flight */
static const double EXPECTED_DIPOLE = 0.4; /* the same of the residual dipole */
static const double PRODUCTS = 0.5;        /* of the moments' deviation: that of the products of inertia */
static const double TRUST = 0.4;           /* largest change of inertia and gains, relative */
static const double REST_NOISE = 2.5e-4;   /* 1/T, standard deviation of the rate after T at rest, by the model's error */
static const double TURN_SHARE = 0.003;    /* of the change of rate by turning: the model's error */
static const double RODS_SHARE = 0.03;     /* of that by the rods */
static const double LASTS = 0.5;           /* T, for which the model's error stays alike */
static const double GATE = 6.0;            /* standard deviations of an innovation that is believed */
static const double EXCESS_TIME = 2.0;     /* T, over which innovations are averaged */
static const double EXCESS_MAX = 1e6;
static const double EVIDENCE_MAX = 25.0; /* beyond which the start is taken again */
static const double TURN_MIN = 1e-8;     /* rad, least standard deviation of a measured attitude */
static const double RATE_MIN = 1e-9;     /* rad/s, of a measured rate */

/* `count` unknowns become independent of all others. */
static void forget(Identification *id, int first, int count, double deviation)
{
    for (int i = MOTION + first; i < MOTION + first + count; ++i) {
        for (int j = 0; j < STATES; ++j) {
            id->P[i][j] = id->P[j][i] = 0.0;
        }
        id->P[i][i] = deviation * deviation;
    }
}

static void begin_properties(Identification *id)
{
    memcpy(id->p + INERTIA, id->start + INERTIA, (TORQUE - INERTIA) * sizeof id->p[0]);
    for (int i = INERTIA; i < INERTIA + 3; ++i) {
        forget(id, i, 1, id->spread * id->start[i]);
    }
    forget(id, INERTIA + 3, 3, PRODUCTS * id->spread * (id->start[3] + id->start[4] + id->start[5]) / 3.0);
    forget(id, GAINS, 3, id->spread);
    id->evidence = 0.0;
}

/* Attitude and rate are those that were measured; the rate's error is then that of noise and bias. */
static void take_measured(Identification *id)
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < STATES; ++j) {
            id->P[i][j] = id->P[j][i] = 0.0;
        }
        for (int j = MOTION; j < STATES; ++j) {
            id->P[RATE + i][j] = id->P[j][RATE + i] = -id->P[MOTION + BIAS + i][j];
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            id->P[RATE + i][RATE + j] = id->P[MOTION + BIAS + i][MOTION + BIAS + j];
        }
    }
    for (int i = 0; i < MOTION; ++i) {
        id->P[i][i] += id->variance[i / RATE] * id->excess[i / RATE];
        for (int j = 0; j < MOTION; ++j) {
            id->gain[i][j] = i == j;
        }
    }
}

void controller_planned_identification_start(const ControllerPlannedParameters *p, const Scales *scales, Identification *id)
{
    const double T = scales->time, inertia = scales->momentum * T;
    const double properties[] = {p->J_B[0][0], p->J_B[1][1], p->J_B[2][2], p->J_B[1][2], p->J_B[2][0],
                                 p->J_B[0][1], 1.0,          1.0,          1.0};
    memset(id, 0, sizeof *id);
    memcpy(id->start + INERTIA, properties, sizeof properties);
    id->spread = p->identify ? p->identify_spread : 0.0;
    id->limit[0] = p->rate_bias_max;
    id->limit[1] = scales->disturbance_max;
    id->limit[2] = scales->residual_dipole_max;
    id->limit[3] = TRUST * inertia;
    id->variance[0] = larger(p->attitude_noise * p->attitude_noise, TURN_MIN * TURN_MIN);
    id->variance[1] = larger(p->rate_noise * p->rate_noise, RATE_MIN * RATE_MIN);
    id->rate_density = REST_NOISE * REST_NOISE / (T * T * T);
    /* The filter at rest then forgets over disturbance_time. */
    id->torque_density =
        id->limit[1] > 0.0 ? id->rate_density * inertia * inertia / (p->disturbance_time * p->disturbance_time) : 0.0;
    id->lasts = LASTS * T;
    id->forgets = EXCESS_TIME * T;
    id->excess[0] = id->excess[1] = 1.0;
    begin_properties(id);
    forget(id, BIAS, 3, EXPECTED * id->limit[0]);
    forget(id, TORQUE, 3, EXPECTED * id->limit[1]);
    forget(id, DIPOLE, 3, EXPECTED_DIPOLE * id->limit[2]);
    take_measured(id);
}

Matrix controller_planned_estimated_inertia(const Identification *id)
{
    const double *a = id->start + INERTIA, *b = id->p + INERTIA;
    for (double share = 1.0; share > 0.1; share *= 0.5) {
        double p[6];
        for (int i = 0; i < 6; ++i) {
            p[i] = share == 1.0 ? b[i] : a[i] + share * (b[i] - a[i]);
        }
        const Matrix J = {{p[0], p[5], p[4]}, {p[5], p[1], p[3]}, {p[4], p[3], p[2]}};
        Fault unused;
        if (is_inertia(J, "", &unused)) {
            return J;
        }
    }
    return (Matrix){{a[0], a[5], a[4]}, {a[5], a[1], a[3]}, {a[4], a[3], a[2]}};
}

double controller_planned_rods_gain(const Identification *id)
{
    return (id->p[GAINS] + id->p[GAINS + 1] + id->p[GAINS + 2]) / 3.0;
}

static void put_column(double G[MOTION][STATES], int column, Vector v)
{
    G[RATE][column] = v.x;
    G[RATE + 1][column] = v.y;
    G[RATE + 2][column] = v.z;
}

static void put_rows(double G[MOTION][STATES], int row, int column, Matrix m)
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
static void sensitivity(const Passed *s, const Identification *id, double G[MOTION][STATES])
{
    const Model *model = s->model;
    const double dt = s->dt;
    const Vector Omega = scale(0.5, add(s->before.Omega, s->after.Omega));
    const Vector change = subtract(s->after.Omega, s->before.Omega);
    const Vector Pi = momentum_of(model, &(Motion){.Omega = Omega, .l = 0.5 * (s->before.l + s->after.l)});
    const Vector rho = apply_transposed(s->before.R, s->around->r_hat_N);
    const Matrix scaled = times(dt, model->J_inverse);
    const Matrix gyroscopic = multiply(scaled, sum(hat(Pi), times(-1.0, multiply(hat(Omega), model->J))));
    memset(G, 0, MOTION * sizeof G[0]);
    put_rows(G, 0, 0, transposed(rotation_exp(scale(dt, Omega))));
    put_rows(G, RATE, RATE, gyroscopic);
    for (int i = 0; i < 3; ++i) {
        G[i][RATE + i] = dt;
        G[RATE + i][RATE + i] += 1.0;
        put_column(G, MOTION + GAINS + i, apply(scaled, cross(s->rods[i], s->B_B)));
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
    put_rows(G, RATE, MOTION + TORQUE, scaled);
    put_rows(G, RATE, MOTION + DIPOLE, multiply(scaled, hat(scale(-1.0, s->B_B))));
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
    return id->excess[1] * density * s->dt;
}

/* P <- F P F^T + Q: F is G in the motion's rows, the identity in those of p. */
void controller_planned_propagate(const Passed *passed, Identification *id)
{
    double G[MOTION][STATES], GP[MOTION][STATES];
    sensitivity(passed, id, G);
    const double variance = model_variance(passed, id);
    for (int i = 0; i < MOTION; ++i) {
        const int last = i < RATE ? MOTION : STATES;
        for (int j = 0; j < STATES; ++j) {
            double sum = 0.0;
            for (int k = 0; k < last; ++k) {
                sum += G[i][k] * id->P[k][j];
            }
            GP[i][j] = sum;
        }
    }
    for (int i = 0; i < MOTION; ++i) {
        for (int j = i; j < MOTION; ++j) {
            double sum = 0.0;
            for (int k = 0; k < (j < RATE ? MOTION : STATES); ++k) {
                sum += GP[i][k] * G[j][k];
            }
            id->P[i][j] = id->P[j][i] = sum;
        }
        for (int j = MOTION; j < STATES; ++j) {
            id->P[i][j] = id->P[j][i] = GP[i][j];
        }
    }
    for (int i = 0; i < 3; ++i) {
        id->P[RATE + i][RATE + i] += variance;
        id->P[MOTION + TORQUE + i][MOTION + TORQUE + i] += id->torque_density * passed->dt;
    }
}

/* The correction by one element of the innovation, at i: of the turn alone, or of rate and bias together. */
static void correct(Identification *id, int i, double innovation, double correction[STATES])
{
    double column[STATES];
    const int other = i < RATE ? i : MOTION + BIAS + i - RATE;
    for (int j = 0; j < STATES; ++j) {
        column[j] = id->P[i][j] + (other != i ? id->P[other][j] : 0.0);
    }
    const double variance = id->variance[i / RATE] * id->excess[i / RATE];
    const double spread = 1.0 / (variance + column[i] + (other != i ? column[other] : 0.0));
    const double error = innovation - correction[i] - (other != i ? correction[other] : 0.0);
    for (int j = 0; j < STATES; ++j) {
        const double factor = column[j] * spread;
        correction[j] += factor * error;
        for (int k = j; k < STATES; ++k) {
            id->P[j][k] -= factor * column[k];
            id->P[k][j] = id->P[j][k];
        }
    }
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

/* Whether the innovations fit their variances; how far they do is averaged. */
static bool is_believed(double dt, const double innovation[MOTION], Identification *id)
{
    double square[2] = {0.0, 0.0};
    bool believed = true;
    for (int i = 0; i < MOTION; ++i) {
        const int kind = i / RATE, b = MOTION + BIAS + i - RATE;
        const double spread =
            id->variance[kind] * id->excess[kind] + id->P[i][i] + (kind == 1 ? 2.0 * id->P[i][b] + id->P[b][b] : 0.0);
        const double ratio = innovation[i] * innovation[i] / spread;
        believed = believed && ratio <= GATE * GATE;
        square[kind] += (ratio <= GATE * GATE ? ratio : GATE * GATE) / 3.0;
    }
    for (int kind = 0; kind < 2; ++kind) {
        id->excess[kind] =
            clip(id->excess[kind] * (1.0 + (square[kind] - 1.0) * smaller(dt / id->forgets, 1.0)), 1.0, EXCESS_MAX);
    }
    return believed;
}

void controller_planned_learn(double dt, Vector turn, Vector rate, Vector nominal, Identification *id)
{
    double innovation[MOTION], correction[STATES] = {0.0};
    store(turn, innovation);
    store(rate, innovation + RATE);
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
    const double expected = id->P[RATE][RATE] + id->variance[1] * id->excess[1];
    id->evidence = larger(id->evidence + 0.5 * (dot(rate, rate) - dot(nominal, nominal)) / expected, 0.0);
    for (int i = 0; i < MOTION; ++i) {
        correct(id, i, innovation[i], correction);
    }
    for (int i = 0; i < MOTION; ++i) {
        for (int j = 0; j < MOTION; ++j) {
            const double covariance = id->P[i][j] + (j < RATE ? 0.0 : id->P[i][MOTION + BIAS + j - RATE]);
            id->gain[i][j] = covariance / (id->variance[j / RATE] * id->excess[j / RATE]);
        }
    }
    for (int i = 0; i < UNKNOWNS; ++i) {
        id->p[i] += correction[MOTION + i];
    }
    keep_all_within(id);
    if (id->evidence > EVIDENCE_MAX) {
        begin_properties(id);
    }
}
