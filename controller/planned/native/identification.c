#include "identification.h"

#include <string.h>

static const double WINDOW = 5.0;      /* s */
static const double NOISE = 1e-4;      /* N m s, of a window's balance of momentum, at least */
static const double NOISE_RATES = 2.8; /* standard deviations of a rate, times the inertia: two ends, and some more */
static const double NOISE_RODS = 0.01; /* of the rods' impulse */
static const double GATE = 5.0;        /* standard deviations */
static const double CHANGE_MIN = 1e-3; /* rad/s, of the rate in a window that tells something */
static const double KNOWN_MIN = 1e-3;  /* N m s, of a known impulse, below which the scale of p cannot be observed */
static const double EXPECTED = 0.25;   /* of the largest disturbance: its standard deviation before the flight */
static const double TRUST = 0.4;       /* largest change of what is identified, relative */

void controller_planned_identification_start(const double inertia[3], double spread, double disturbance_max,
                                             double disturbance_time, double dipole_max, double rate_noise, Identification *id)
{
    memset(id, 0, sizeof *id);
    id->disturbance_max = disturbance_max;
    id->dipole_max = dipole_max;
    /* The walk for which the filter at rest forgets over disturbance_time. */
    const double noise = larger(NOISE, NOISE_RATES * rate_noise * largest(vector(inertia)));
    id->rate_noise = rate_noise;
    id->walk = noise / WINDOW * (WINDOW / disturbance_time);
    for (int i = 0; i < UNKNOWNS; ++i) {
        id->p[i] = i < 3 ? inertia[i] : i == GAIN ? 1.0 : 0.0;
        const double deviation = i < TORQUE ? spread * id->p[i] : EXPECTED * (i < DIPOLE ? disturbance_max : dipole_max);
        id->P[i][i] = deviation * deviation;
        if (i < TORQUE) {
            id->start[i] = id->p[i];
        }
    }
}

/* One equation row.p = value with the variance of its noise. */
static void update(Identification *id, const double row[UNKNOWNS], double value, double variance, bool quiet)
{
    double Pr[UNKNOWNS], spread = variance, error = value;
    for (int i = 0; i < UNKNOWNS; ++i) {
        Pr[i] = 0.0;
        for (int j = 0; j < UNKNOWNS; ++j) {
            Pr[i] += id->P[i][j] * row[j];
        }
    }
    for (int i = 0; i < UNKNOWNS; ++i) {
        spread += row[i] * Pr[i];
        error -= row[i] * id->p[i];
    }
    if (!(error * error <= GATE * GATE * spread && isfinite(spread))) {
        return;
    }
    /* Without a known impulse the row tells of ratios only: its noise alone would draw all of p towards zero. Rods that are
     * at rest have no part in the ratios. */
    const int ratios = fabs(row[GAIN]) >= KNOWN_MIN ? TORQUE : GAIN;
    double scale_before = 0.0, scale_after = 0.0;
    for (int i = 0; i < UNKNOWNS; ++i) {
        scale_before += i < ratios ? id->p[i] / id->start[i] : 0.0;
        id->p[i] += Pr[i] * error / spread;
        scale_after += i < ratios ? id->p[i] / id->start[i] : 0.0;
    }
    for (int i = 0; i < ratios && !quiet && fabs(value) < KNOWN_MIN; ++i) {
        id->p[i] *= scale_before / scale_after;
    }
    for (int i = 0; i < UNKNOWNS; ++i) {
        for (int j = 0; j < UNKNOWNS; ++j) {
            id->P[i][j] -= Pr[i] * Pr[j] / spread;
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

static void use_window(Identification *id, Vector Omega, double l, bool inertia)
{
    double dOmega[3], products[3], rods[3], others[3], wheel[3], field[3];
    store(subtract(Omega, id->Omega_0), dOmega);
    store(id->products, products);
    store(id->rods, rods);
    store(id->others, others);
    store(id->wheel, wheel);
    store(id->field, field);
    const double dl[3] = {l - id->l_0, 0.0, 0.0};
    const bool quiet = !inertia || norm(vector(dOmega)) < CHANGE_MIN;
    for (int i = 0; i < 3; ++i) {
        id->P[TORQUE + i][TORQUE + i] += id->walk * id->walk;
    }
    for (int i = 0; i < 3; ++i) {
        /* J_i dOmega_i + (J_k - J_j) int Omega_j Omega_k - gain int tau_i - d_i T = int known - dl - int (Omega x l e1)_i */
        double row[UNKNOWNS] = {0.0};
        row[i] = dOmega[i];
        row[(i + 1) % 3] = -products[i];
        row[(i + 2) % 3] = products[i];
        row[GAIN] = -rods[i];
        double value = others[i] - dl[i] - wheel[i];
        for (int j = 0; j < TORQUE && quiet; ++j) {
            value -= row[j] * id->p[j];
            row[j] = 0.0;
        }
        row[TORQUE + i] = -id->elapsed;
        /* -int (m x B)_i */
        row[DIPOLE + (i + 1) % 3] = -field[(i + 2) % 3];
        row[DIPOLE + (i + 2) % 3] = field[(i + 1) % 3];
        const double noise = larger(NOISE, NOISE_RATES * id->rate_noise * id->start[i]);
        const double variance = noise * noise + NOISE_RODS * NOISE_RODS * rods[i] * rods[i];
        update(id, row, value, variance, quiet);
    }
    for (int i = 0; i < TORQUE; ++i) {
        id->p[i] = larger(smaller(id->p[i], (1.0 + TRUST) * id->start[i]), (1.0 - TRUST) * id->start[i]);
    }
    keep_within(id->p + TORQUE, id->disturbance_max);
    keep_within(id->p + DIPOLE, id->dipole_max);
}

void controller_planned_identify(double dt, Vector Omega, Vector Omega_next, double l, double l_next, Vector tau_rods,
                                 Vector tau_known, Vector B_B, bool inertia, Identification *id)
{
    if (id->elapsed == 0.0) {
        id->Omega_0 = Omega;
        id->l_0 = l;
        id->products = id->rods = id->others = id->wheel = id->field = (Vector){0.0, 0.0, 0.0};
    }
    const Vector a = {Omega.y * Omega.z, Omega.z * Omega.x, Omega.x * Omega.y};
    const Vector b = {Omega_next.y * Omega_next.z, Omega_next.z * Omega_next.x, Omega_next.x * Omega_next.y};
    id->products = add(id->products, scale(0.5 * dt, add(a, b)));
    id->rods = add(id->rods, scale(dt, tau_rods));
    id->others = add(id->others, scale(dt, tau_known));
    id->field = add(id->field, scale(dt, B_B));
    const double m = 0.5 * dt;
    id->wheel =
        add(id->wheel, (Vector){0.0, m * (Omega.z * l + Omega_next.z * l_next), -m * (Omega.y * l + Omega_next.y * l_next)});
    id->elapsed += dt;
    if (id->elapsed >= WINDOW - 1e-9) {
        use_window(id, Omega_next, l_next, inertia);
        id->elapsed = 0.0;
    }
}
