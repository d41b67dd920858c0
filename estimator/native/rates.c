/* Tests: tests/native/test_flavours.py. */
#include "rates.h"

static const double STEP = 0.5; /* s, longest step of the integration */

Vector estimator_turn_by_gyro(Vector before, Vector now, double h, double since)
{
    const Vector mean = add(scale(h, before), scale(0.5 * since, subtract(now, before)));
    return add(mean, scale(h * h / 12.0, cross(before, now)));
}

static Vector with_wheels(const Torques *torques, Vector omega, Vector momentum_B)
{
    return add(apply(torques->J, omega), momentum_B);
}

/* J d omega/dt = (J omega + l) x omega + m x B + nadir x J nadir - dl/dt + d, l of all wheels. */
static Vector acceleration(const Torques *torques, Matrix R, Vector omega, Vector momentum_B)
{
    const Vector nadir = apply_transposed(R, torques->nadir_N), field = apply_transposed(R, torques->field_N);
    Vector torque = add(cross(with_wheels(torques, omega, momentum_B), omega), cross(torques->dipole_B, field));
    torque = add(add(torque, torques->disturbance_B), cross(nadir, apply(torques->J, nadir)));
    return apply(torques->J_inverse, subtract(torque, torques->wheel_B));
}

Matrix estimator_rate_growth(const Torques *torques, Vector omega, Vector momentum_B)
{
    const Vector L = with_wheels(torques, omega, momentum_B);
    const Matrix J = torques->J;
    const Matrix columns = {/* of L^ - omega^ J, as rows */
                            subtract(cross(L, (Vector){1.0, 0.0, 0.0}), cross(omega, (Vector){J.a.x, J.b.x, J.c.x})),
                            subtract(cross(L, (Vector){0.0, 1.0, 0.0}), cross(omega, (Vector){J.a.y, J.b.y, J.c.y})),
                            subtract(cross(L, (Vector){0.0, 0.0, 1.0}), cross(omega, (Vector){J.a.z, J.b.z, J.c.z}))};
    return multiply(torques->J_inverse, transposed(columns));
}

Vector estimator_turn_by_dynamics(const Torques *torques, Vector momentum_B, double h, Matrix *R, Vector *omega)
{
    const int steps = steps_of(h, STEP);
    const double dt = h / steps;
    Vector whole = {0.0, 0.0, 0.0};
    for (int i = 0; i < steps; ++i) {
        const Vector w = *omega;
        const Matrix half = multiply(*R, rotation_exp(scale(0.5 * dt, w))),
                     next = multiply(*R, rotation_exp(scale(dt, w)));
        const Vector gained = scale(0.5 * dt, torques->wheel_B), half_l = add(momentum_B, gained);
        momentum_B = add(momentum_B, scale(dt, torques->wheel_B));
        const Vector a1 = acceleration(torques, *R, w, subtract(half_l, gained));
        const Vector a2 = acceleration(torques, half, add(w, scale(0.5 * dt, a1)), half_l);
        const Vector a3 = acceleration(torques, half, add(w, scale(0.5 * dt, a2)), half_l);
        const Vector a4 = acceleration(torques, next, add(w, scale(dt, a3)), momentum_B);
        *omega = add(w, scale(dt / 6.0, add(add(a1, a4), scale(2.0, add(a2, a3)))));
        const Vector bend = add(cross(w, *omega), subtract(a1, a4));
        const Vector turn = add(scale(0.5 * dt, add(w, *omega)), scale(dt * dt / 12.0, bend));
        *R = multiply(*R, rotation_exp(turn));
        whole = add(whole, turn);
    }
    return whole;
}
