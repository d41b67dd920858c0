#include "identification.h"

#include <string.h>

static const double WINDOW = 0.1;       /* T */
static const double NOISE_RATES = 2.8;  /* standard deviations of a rate, times the inertia: two ends, and some more */
static const double NOISE_RODS = 0.01;  /* of the rods' impulse */
static const double GATE = 5.0;         /* standard deviations */
static const double CHANGE_TIME = 20.0; /* T, in which the least change of rate that tells something turns by a radian */
static const double EXPECTED = 0.25;    /* of the largest disturbance: its standard deviation before the flight */
static const double TRUST = 0.4;        /* largest change of what is identified, relative */

void controller_planned_identification_start(const Scales *scales, const double inertia[3], double spread,
                                             double disturbance_time, double rate_noise, Identification *id)
{
    memset(id, 0, sizeof *id);
    id->disturbance_max = scales->disturbance_max;
    id->dipole_max = scales->residual_dipole_max;
    id->window = WINDOW * scales->time;
    id->noise = scales->balance_noise;
    id->change_min = 1.0 / (CHANGE_TIME * scales->time);
    id->known_min = scales->known_min;
    /* The walk for which the filter at rest forgets over disturbance_time. */
    const double noise = larger(id->noise, NOISE_RATES * rate_noise * largest(vector(inertia)));
    id->rate_noise = rate_noise;
    id->walk = noise / id->window * (id->window / disturbance_time);
    for (int i = 0; i < UNKNOWNS; ++i) {
        id->p[i] = i < 3 ? inertia[i] : i == GAIN ? 1.0 : 0.0;
        const double deviation =
            i < TORQUE ? spread * id->p[i] : EXPECTED * (i < DIPOLE ? id->disturbance_max : id->dipole_max);
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
    const int ratios = fabs(row[GAIN]) >= id->known_min ? TORQUE : GAIN;
    double scale_before = 0.0, scale_after = 0.0;
    for (int i = 0; i < UNKNOWNS; ++i) {
        scale_before += i < ratios ? id->p[i] / id->start[i] : 0.0;
        id->p[i] += Pr[i] * error / spread;
        scale_after += i < ratios ? id->p[i] / id->start[i] : 0.0;
    }
    for (int i = 0; i < ratios && !quiet && fabs(value) < id->known_min; ++i) {
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

static void use_window(Identification *id, Vector wheel_axis, Vector Omega, double l, bool inertia)
{
    double dOmega[3], products[3], rods[3], others[3], wheel[3], field[3], dl[3];
    store(subtract(Omega, id->Omega_0), dOmega);
    store(id->products, products);
    store(id->rods, rods);
    store(id->others, others);
    store(id->wheel, wheel);
    store(id->field, field);
    store(scale(l - id->l_0, wheel_axis), dl);
    const bool quiet = !inertia || norm(vector(dOmega)) < id->change_min;
    for (int i = 0; i < 3; ++i) {
        id->P[TORQUE + i][TORQUE + i] += id->walk * id->walk;
    }
    for (int i = 0; i < 3; ++i) {
        /* J_i dOmega_i + (J_k - J_j) int Omega_j Omega_k - gain int tau_i - d_i T = int known - dl a_i - int (Omega x l a)_i */
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
        const double noise = larger(id->noise, NOISE_RATES * id->rate_noise * id->start[i]);
        const double variance = noise * noise + NOISE_RODS * NOISE_RODS * rods[i] * rods[i];
        update(id, row, value, variance, quiet);
    }
    for (int i = 0; i < TORQUE; ++i) {
        id->p[i] = larger(smaller(id->p[i], (1.0 + TRUST) * id->start[i]), (1.0 - TRUST) * id->start[i]);
    }
    keep_within(id->p + TORQUE, id->disturbance_max);
    keep_within(id->p + DIPOLE, id->dipole_max);
}

void controller_planned_identify(double dt, Vector wheel_axis, Vector Omega, Vector Omega_next, double l, double l_next,
                                 Vector tau_rods, Vector tau_known, Vector B_B, bool inertia, Identification *id)
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
    const Vector spin = scale(0.5 * dt, add(scale(l, Omega), scale(l_next, Omega_next)));
    id->wheel = add(id->wheel, cross(spin, wheel_axis));
    id->elapsed += dt;
    if (id->elapsed >= id->window * (1.0 - 1e-9)) {
        use_window(id, wheel_axis, Omega_next, l_next, inertia);
        id->elapsed = 0.0;
    }
}
