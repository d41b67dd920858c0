/* docs/how/planned-plan.md, Acquisition. Tests: test_plan.py, test_rods_alone.py. */
#include "cost.h"

static const double BEND = 0.1;                            /* rad, of the pseudo-Huber cost of the angle */
static const double NEAR_ANGLE = 0.078, NEAR_RATE = 0.045; /* rad (4.5 deg), 1/T: 0.9 of what is called settled */
static const double FAR = 0.07;                            /* rad (4 deg), from which an angle is far */

/* N m s: of the wheel's momentum l, what is beyond from where it costs more, near its limit; else 0. */
static double beyond_near_limit(const Model *model, double l)
{
    const double limit = model->scales.near_limit;
    return l > limit ? l - limit : l < -limit ? l + limit : 0.0;
}

/* e^2/2 of the angle e beyond FAR, but no more than BEND^2/2, so that a large error that cannot be avoided does not
 * outweigh the rest. Its second derivative in any direction is at most `curvature`. */
static double far_cost(double angle, double *slope, double *curvature)
{
    const double e = larger(angle - FAR, 0.0), q = 1.0 + e * e / (BEND * BEND);
    *slope = e / (q * q);
    *curvature = e > 0.0 ? 1.0 / (q * q) : 0.0;
    return 0.5 * e * e / q;
}

double controller_planned_cost_of(const Model *model, const Target *target, const Motion *x, double scale_errors,
                                  double scale_wheel, double gradient[ERRORS], double hessian[ERRORS], bool *near)
{
    const double weight_angle = model->scales.weight_angle, weight_rate = model->scales.weight_rate,
                 weight_far = model->scales.weight_far, weight_wheel = model->scales.weight_wheel,
                 weight_near_limit = model->scales.weight_near_limit;
    const Matrix back = transposed(target->R), Q = product_of(&back, &x->R);
    const Vector zeta = rotation_log(Q), w = apply_transposed(Q, target->Omega);
    const Vector omega = subtract(x->Omega, w);
    const double angle = norm(zeta), root = sqrt(dot(zeta, zeta) + BEND * BEND);
    double slope = 0.0, curvature = 0.0;
    const double far = weight_far > 0.0 ? weight_far * far_cost(angle, &slope, &curvature) : 0.0;
    const double over = beyond_near_limit(model, x->l);
    if (near != NULL) {
        *near = angle < NEAR_ANGLE && norm(omega) * model->scales.time < NEAR_RATE;
    }
    if (gradient != NULL) {
        const double of_far = slope > 0.0 ? scale_errors * weight_far * slope / angle : 0.0;
        const double a = scale_errors * weight_angle * BEND / root + of_far, b = scale_errors * weight_rate;
        const double along = larger(scale_errors * weight_far * curvature - of_far, 0.0);
        /* d omega = d Omega - w x d theta */
        const Vector by_angle = add(scale(a, zeta), scale(b, cross(w, omega)));
        store(by_angle, gradient);
        store(scale(b, omega), gradient + 3);
        gradient[6] = scale_wheel * (weight_wheel * x->l + weight_near_limit * over);
        for (int i = 0; i < 3; ++i) {
            hessian[i] = a + along;
            hessian[3 + i] = b;
        }
        hessian[6] = scale_wheel * (weight_wheel + (over != 0.0 ? weight_near_limit : 0.0));
    }
    return scale_errors * (weight_angle * BEND * (root - BEND) + far + 0.5 * weight_rate * dot(omega, omega)) +
           scale_wheel * 0.5 * (weight_wheel * x->l * x->l + weight_near_limit * over * over);
}
