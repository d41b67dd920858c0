/* The Kalman filter before the flight, and where it begins anew: docs/how/planned-estimates.md, Estimates.
 * Requirement: PL-1. Tests: test_identification.py, test_failures_estimated.py. */
#include "identification.h"

#include <string.h>

static const double EXPECTED = 0.25;       /* of a largest value: its standard deviation before the flight */
static const double EXPECTED_DIPOLE = 0.4; /* the same of the residual dipole */
static const double PRODUCTS = 0.5;        /* of the moments' deviation: that of the products of inertia */
static const double BIAS_TIME = 1e5;       /* s, in which the bias of the rate may become another */
static const double REST_NOISE = 2.5e-4; /* 1/T, standard deviation of the rate after T at rest, by the model's error */
static const double LASTS = 0.5;         /* T, for which the model's error stays alike */
static const double EXCESS_TIME = 2.0;   /* T, over which innovations are averaged */
static const double WIDE_SPREAD = 1.0;   /* standard deviation of the gains where a rod is suspected */
static const double STUCK_ON_SPREAD = 0.1; /* the same of the dipole, of a rod at its limit: it may be stuck on */
static const double PAUSE = 2.0;           /* T, until the gains are known after that; each time twice as long */

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

static void begin_torques(double stuck_on, Identification *id)
{
    forget(id, TORQUE, 3, EXPECTED * id->limit[1]);
    forget(id, DIPOLE, 3, larger(EXPECTED_DIPOLE * id->limit[2], stuck_on));
}

void controller_planned_begin_properties(Identification *id)
{
    memcpy(id->p + INERTIA, id->start + INERTIA, (TORQUE - INERTIA) * sizeof id->p[0]);
    for (int i = 0; i < 6; ++i) {
        forget(id, INERTIA + i, 1, id->inertia_spread[i]);
    }
    for (int i = 0; i < 3; ++i) {
        forget(id, GAINS + i, 1, id->spread * fabs(id->start[GAINS + i]));
    }
    id->evidence = 0.0;
    id->watch.wide = false;
}

static void begin_unknowns(double stuck_on, Identification *id)
{
    controller_planned_begin_properties(id);
    memset(id->p + TORQUE, 0, (UNKNOWNS - TORQUE) * sizeof id->p[0]);
    begin_torques(stuck_on, id);
}

void controller_planned_set_taught(bool taught, Identification *id)
{
    if (id->taught && !taught && id->watch.wide) {
        begin_unknowns(0.0, id);
    }
    id->taught = taught;
}

void controller_planned_suspect_rods(Identification *id)
{
    begin_unknowns(STUCK_ON_SPREAD * id->dipole, id);
    forget(id, GAINS, 3, WIDE_SPREAD);
    id->excess[0] = id->excess[1] = id->excess[2] = 1.0;
    id->alike[0] = id->alike[1] = 0.0;
    id->watch.wide = true;
    controller_planned_pause_watch(id->time, &id->watch);
}

void controller_planned_take_attitude(Identification *id)
{
    for (int i = 0; i < RATE_STATE; ++i) {
        for (int j = 0; j < FILTER_STATES; ++j) {
            id->P[i][j] = id->P[j][i] = 0.0;
        }
        memset(id->gain[i], 0, sizeof id->gain[i]);
        id->gain[i][i] = 1.0;
    }
    id->P[0][0] = id->sigma_B.x * id->sigma_B.x;
    id->P[1][1] = id->sigma_B.y * id->sigma_B.y;
    id->P[2][2] = id->sigma_B.z * id->sigma_B.z;
}

void controller_planned_take_measured(Identification *id)
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
    return (Matrix){
        {spread * J.a.x, product, product}, {product, spread * J.b.y, product}, {product, product, spread * J.c.z}};
}

/* The six elements of a symmetric matrix, in the order of p. */
static void store_symmetric(Matrix m, double p[6])
{
    const double elements[6] = {m.a.x, m.b.y, m.c.z, m.b.z, m.c.x, m.a.y};
    memcpy(p, elements, sizeof elements);
}

void controller_planned_set_noise(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u,
                                  Identification *id)
{
    id->variance[0] = p->attitude_noise * p->attitude_noise;
    id->variance[1] = p->rate_noise * p->rate_noise;
    id->estimated = id->spread > 0.0 && controller_planned_has_attitude_sigma_B(u); /* what is learned */
    if (id->estimated) {
        id->sigma_B = vector(u->attitude_sigma_B);
        id->bias_density = id->limit[0] = 0.0;
        memset(id->p + BIAS, 0, 3 * sizeof id->p[0]);
        forget(id, BIAS, 3, 0.0);
    }
}

void controller_planned_set_disturbance(const Scales *scales, bool strained, Identification *id)
{
    const double inertia = scales->momentum * scales->time;
    const double forgotten = strained ? scales->strained_disturbance_time : scales->disturbance_time;
    id->limit[1] = strained ? scales->strained_disturbance_max : scales->disturbance_max;
    /* The filter at rest then forgets over that time. */
    id->torque_density = id->limit[1] > 0.0 ? id->rate_density * inertia * inertia / (forgotten * forgotten) : 0.0;
}

void controller_planned_identification_start(const ControllerPlannedParameters *p, const ControllerPlannedInputs *u,
                                             const Scales *scales, Identification *id)
{
    const double T = scales->time;
    memset(id, 0, sizeof *id);
    store_symmetric(matrix(p->J_B), id->start + INERTIA);
    store_symmetric(controller_planned_sigma_before(p), id->inertia_spread);
    store(vector(p->rod_gains0), id->start + GAINS);
    id->spread = p->identify ? p->identify_spread : 0.0;
    id->limit[0] = p->rate_bias_max;
    id->limit[2] = scales->residual_dipole_max;
    id->dipole = p->dipole_max * largest(vector(p->rod_limits));
    id->limit[3] = PRODUCTS * TRUST * scales->momentum * T;
    controller_planned_set_noise(p, u, id);
    id->rate_density = REST_NOISE * REST_NOISE / (T * T * T);
    id->bias_density = EXPECTED * EXPECTED * id->limit[0] * id->limit[0] / BIAS_TIME;
    controller_planned_set_disturbance(scales, false, id);
    id->time = T;
    id->watch.pause = PAUSE * T;
    id->lasts = LASTS * T;
    id->forgets = EXCESS_TIME * T;
    id->excess[0] = id->excess[1] = id->excess[2] = 1.0;
    controller_planned_begin_properties(id);
    forget(id, BIAS, 3, EXPECTED * id->limit[0]);
    begin_torques(0.0, id);
    controller_planned_take_measured(id);
}
