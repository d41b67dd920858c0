/* Flat arrays of doubles, as Python gives them, and the planned controller's structures: what the probes share. */
#ifndef PROBE_FLAT_H
#define PROBE_FLAT_H

#include <string.h>

#include "controller_planned.h"
#include "gauss_models.h"
#include "plan/renew.h"

#if defined _WIN32
#define PROBE __declspec(dllexport)
#else
#define PROBE __attribute__((visibility("default")))
#endif

typedef struct {
    double J[3][3], rods[3][3], wheel_axis[3], wheel_torque_max, wheel_momentum_max, disturbance_B[3], residual_B[3];
    double dipole_max, semi_major_axis;
} FlatModel;

typedef struct {
    double B_N[3], r_hat_N[3], rate_squared;
} FlatAround;

typedef struct {
    double R[3][3], Omega[3], l;
} FlatMotion;

/* The orbit and field of a plan. */
typedef struct {
    double t, mu, r[3], v[3], days, bias_N[3], bias_t, R_d0[3][3];
    int32_t model, degree, target;
} FlatAhead;

static inline Matrix nine(const double m[9])
{
    return (Matrix){vector(m), vector(m + 3), vector(m + 6)};
}

static inline void nine_of(Matrix m, double out[9])
{
    store(m.a, out);
    store(m.b, out + 3);
    store(m.c, out + 6);
}

static inline Model model_of(const FlatModel *f)
{
    Model m;
    memset(&m, 0, sizeof m);
    m.J = matrix(f->J);
    m.J_inverse = inverse(m.J);
    for (int i = 0; i < 3; ++i) {
        m.rods[i] = vector(f->rods[i]);
    }
    m.wheel_torque_max = f->wheel_torque_max;
    m.wheel_momentum_max = f->wheel_momentum_max;
    m.disturbance_B = vector(f->disturbance_B);
    m.residual_B = vector(f->residual_B);
    m.wheel_axis = vector(f->wheel_axis);
    ControllerPlannedParameters p;
    memset(&p, 0, sizeof p);
    store_matrix(m.J, p.J_B);
    p.control_period = 0.5;
    p.momentum_weight = 0.018;
    p.dipole_max = f->dipole_max;
    p.rod_limits[0] = p.rod_limits[1] = p.rod_limits[2] = 1.0;
    p.wheel_momentum_max = f->wheel_momentum_max;
    memcpy(p.wheel_axis, f->wheel_axis, sizeof p.wheel_axis);
    p.gravitational_parameter = 3.986004418e14;
    m.scales = controller_planned_scales(&p, f->semi_major_axis);
    m.horizon = controller_planned_horizon(m.scales.time);
    if (!has_wheel(&m)) {
        const Plan none = {.stages = 0};
        controller_planned_plan_by_rods(&m, &none);
    }
    return m;
}

static inline Around around_of(const FlatAround *f)
{
    return (Around){vector(f->B_N), vector(f->r_hat_N), f->rate_squared, {0.0, 0.0, 0.0}};
}

static inline Motion motion_of(const FlatMotion *f)
{
    return (Motion){matrix(f->R), vector(f->Omega), f->l};
}

static inline void flatten(const Motion *x, FlatMotion *f)
{
    store_matrix(x->R, f->R);
    store(x->Omega, f->Omega);
    f->l = x->l;
}

static inline Ahead ahead_of_flat(const FlatAhead *f, OnboardField *field)
{
    const double none[3] = {0.0, 0.0, 0.0};
    onboard_field(&gauss_models[f->model - 1], f->days, f->degree, none, field);
    const TwoBody orbit = {f->t, f->mu, vector(f->r), vector(f->v)};
    return (Ahead){.field = field,
                   .orbit = orbit,
                   .bias_N = vector(f->bias_N),
                   .bias_t = f->bias_t,
                   .target_kind = f->target,
                   .R_d0 = matrix(f->R_d0)};
}

#endif
