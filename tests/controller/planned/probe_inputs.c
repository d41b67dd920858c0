/* The planned controller's functions of epoch, field, orbit and target, for tests: flat arrays in, flat arrays out. */
#include "probe_flat.h"

PROBE int probe_days(const char *text, double *days)
{
    Epoch epoch;
    const bool read = epoch_read(text, &epoch);
    *days = read ? days_of_epoch(&epoch) : 0.0;
    return read;
}

PROBE double probe_year(double days)
{
    return year_of_days(days);
}

PROBE void probe_field(int model, double days, int degree, const double error[3], double t, int n, const double *r,
                       double *B)
{
    OnboardField field;
    onboard_field(&gauss_models[model - 1], days, degree, error, &field);
    for (int i = 0; i < n; ++i) {
        store(onboard_field_at(&field, t, vector(r + 3 * i)), B + 3 * i);
    }
}

PROBE double probe_sidereal(double days)
{
    OnboardField field;
    const double none[3] = {0.0, 0.0, 0.0};
    onboard_field(&gauss_models[0], days, 1, none, &field);
    return field.sidereal_angle;
}

PROBE void probe_orbit(double mu, const double r[3], const double v[3], double dt, double out[6])
{
    const TwoBody orbit = {5.0, mu, vector(r), vector(v)};
    Vector r_N, v_N;
    two_body_at(&orbit, 5.0 + dt, &r_N, &v_N);
    store(r_N, out);
    store(v_N, out + 3);
}

PROBE void probe_log(int n, const double *R, double *zeta)
{
    for (int i = 0; i < n; ++i) {
        store(rotation_log(nine(R + 9 * i)), zeta + 3 * i);
    }
}

PROBE void probe_target(const double r[3], const double v[3], double R[9], double Omega[3])
{
    const Target target = controller_planned_lvlh(vector(r), vector(v));
    nine_of(target.R, R);
    store(target.Omega, Omega);
}

/* The target at each time of n, where r, v, a reference and the reference to come are given at 0. */
PROBE void probe_target_ahead(const double *inputs, int n, const double *t, double *R, double *Omega)
{
    static ControllerPlannedLaw law;
    static ControllerPlannedState x;
    ControllerPlannedInputs u;
    law.p.control_period = 0.5;
    law.p.gravitational_parameter = 3.986004418e14;
    memset(&u, 0, sizeof u);
    double *const fields[] = {u.r_N,        u.v_N,     u.R_ref[0],      u.Omega_ref,
                              u.dOmega_ref, u.t_ahead, u.turn_ahead[0], u.Omega_ahead[0]};
    const size_t sizes[] = {3, 3, 9, 3, 3, AHEAD_TIMES, 3 * AHEAD_TIMES, 3 * AHEAD_TIMES};
    for (int i = 0; i < 8; inputs += sizes[i], ++i) {
        memcpy(fields[i], inputs, sizes[i] * sizeof *inputs);
    }
    const Ahead ahead = controller_planned_ahead_of(&law, &x, &u);
    for (int i = 0; i < n; ++i) {
        const Target target = controller_planned_target_at(&ahead, t[i]);
        nine_of(target.R, R + 9 * i);
        store(target.Omega, Omega + 3 * i);
    }
}
