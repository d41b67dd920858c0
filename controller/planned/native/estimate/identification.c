/* Which samples the Kalman filter accepts, and what limits its estimates: docs/how/planned-estimates.md, Estimates.
 * Tests: test_identification.py, test_failures.py. */
#include "identification.h"

#include <string.h>

#include "rotation.h"

static const double GATE = 6.0;  /* standard deviations of an innovation that is accepted */
static const double ALIKE = 0.2; /* mean cosine of innovations in turn, above which the model is the cause */
static const double EXCESS_MAX = 1e6;
static const double EVIDENCE_MAX = 25.0; /* beyond which the start is taken again */
static const double WIDE_TRUST = 2.5;    /* largest change of a gain there */
static const double FAILED_SIGMA = 0.15; /* standard deviation of a gain from which on it is known */
static const double SOUND = 0.2;         /* change of a gain that a sound rod may have */
static const double CERTAIN = 4.0;       /* deviations beyond that: one false alarm in 15,000 suspicions */
static const double STUCK_ON_MAX = 0.5;  /* of a rod at its limit: largest dipole, with one that is stuck on */

enum { HALVINGS = 4 }; /* of what is estimated less the start, until it is the inertia of a body */

static Matrix symmetric(const double p[6])
{
    return (Matrix){{p[0], p[5], p[4]}, {p[5], p[1], p[3]}, {p[4], p[3], p[2]}};
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
    return (fabs(id->p[GAINS]) + fabs(id->p[GAINS + 1]) + fabs(id->p[GAINS + 2])) / 3.0;
}

int32_t controller_planned_failed_rod(const Identification *id)
{
    int32_t failed = 0;
    double farthest = TRUST;
    for (int i = 0; i < 3 && id->watch.wide; ++i) {
        const double change = fabs(id->p[GAINS + i] - id->start[GAINS + i]);
        const double sigma = sqrt(larger(id->P[MOTION + GAINS + i][MOTION + GAINS + i], 0.0));
        if (sigma < FAILED_SIGMA && change > farthest && change > SOUND + CERTAIN * sigma) {
            failed = i + 1;
            farthest = change;
        }
    }
    return failed;
}

bool controller_planned_stuck_on(const Identification *id)
{
    const int at = MOTION + DIPOLE;
    const double sigma = sqrt(larger(id->P[at][at] + id->P[at + 1][at + 1] + id->P[at + 2][at + 2], 0.0));
    return id->watch.wide && norm(vector(id->p + DIPOLE)) > id->limit[2] + CERTAIN * sigma;
}

static void keep_within(double v[3], double limit)
{
    const double size = norm(vector(v));
    for (int i = 0; i < 3 && size > limit; ++i) {
        v[i] *= limit / size;
    }
}

/* Whether a gain was beyond its limit. */
static bool keep_all_within(Identification *id)
{
    const double of_gains = id->watch.wide ? WIDE_TRUST : TRUST;
    bool beyond = false;
    for (int i = INERTIA; i < TORQUE; ++i) {
        const bool product = i >= INERTIA + 3 && i < GAINS;
        const double room = product ? id->limit[3] : i < GAINS ? TRUST * id->start[i] : of_gains;
        beyond = beyond || (i >= GAINS && fabs(id->p[i] - id->start[i]) > room);
        id->p[i] = clip(id->p[i], id->start[i] - room, id->start[i] + room);
    }
    keep_within(id->p + BIAS, id->limit[0]);
    keep_within(id->p + TORQUE, id->limit[1]);
    keep_within(id->p + DIPOLE, larger(id->limit[2], id->watch.wide ? STUCK_ON_MAX * id->dipole : 0.0));
    return beyond;
}

/* Variances that are too small for the mean squares of the innovations grow, and shrink again: of two innovations in
 * turn that are alike the model is the cause, of others the noise of what is measured. */
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
static bool is_accepted(double dt, const double innovation[MOTION], Identification *id)
{
    double square[2] = {id->estimated ? 1.0 : 0.0, 0.0};
    bool accepted = true;
    for (int i = id->estimated ? RATE_STATE : 0; i < MOTION; ++i) {
        const int kind = i / RATE_STATE, b = MOTION + BIAS + i - RATE_STATE;
        const double spread =
            id->variance[kind] * id->excess[kind] + id->P[i][i] + (kind == 1 ? 2.0 * id->P[i][b] + id->P[b][b] : 0.0);
        const double ratio = innovation[i] * innovation[i] / spread;
        accepted = accepted && (ratio <= GATE * GATE || id->variance[kind] == 0.0);
        square[kind] += (ratio <= GATE * GATE ? ratio : GATE * GATE) / 3.0;
    }
    const Vector none = {0.0, 0.0, 0.0},
                 both[2] = {id->estimated ? none : vector(innovation), vector(innovation + RATE_STATE)};
    widen(dt, square, both, id);
    return accepted;
}

/* Whether a rod may have failed, by what the innovations of the rate show over some time. */
static bool watch(double dt, Vector rate, Identification *id)
{
    double S = 0.0;
    for (int i = 0; i < 3; ++i) {
        const int r = RATE_STATE + i, b = MOTION + BIAS + i;
        S += (id->variance[1] * id->excess[1] + id->P[r][r] + 2.0 * id->P[r][b] + id->P[b][b]) / 3.0;
    }
    return S > 0.0 && controller_planned_watch_rods(dt, id->time, rate, S, &id->watch);
}

void controller_planned_learn(double dt, Vector turn, Vector rate, Vector nominal, bool watched, Identification *id)
{
    double innovation[MOTION];
    store(turn, innovation);
    store(rate, innovation + RATE_STATE);
    id->bias = vector(id->p + BIAS);
    if (!id->taught) {
        controller_planned_take_measured(id);
        return;
    }
    const bool suspected = watched && watch(dt, rate, id);
    if (suspected) {
        controller_planned_suspect_rods(id);
    }
    if (!is_accepted(dt, innovation, id)) {
        id->rejected = id->rejected < 2 ? id->rejected + 1 : 2;
        memset(id->gain, 0, sizeof id->gain);
        if (id->rejected > 1) {
            controller_planned_take_measured(id); /* twice in turn: it is the prediction that is wrong */
        } else if (id->estimated) {
            controller_planned_take_attitude(id);
        }
        return;
    }
    id->rejected = 0;
    const double expected = id->P[RATE_STATE][RATE_STATE] + id->variance[1] * id->excess[1];
    id->evidence = larger(id->evidence + 0.5 * (dot(rate, rate) - dot(nominal, nominal)) / expected, 0.0);
    controller_planned_correct(innovation, id);
    const bool beyond = keep_all_within(id);
    if (beyond && watched && !id->watch.wide && !(id->watch.paused > 0.0)) {
        controller_planned_suspect_rods(id);
    }
    if (id->evidence > EVIDENCE_MAX) {
        controller_planned_begin_properties(id);
    }
}
