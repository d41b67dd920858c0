/* Tests: tests/native/test_plant.py. */
#include "plant.h"

#include <string.h>

#include "rods.h"
#include "rotation.h"
#include "solar_pressure.h"
#include "time_scales.h"

static const double INTERNAL_STEPS_MAX = 1e6; /* in one communication step */

/* The torques on the satellite over a step. */
typedef struct {
    PlantLaw *plant;
    Vector dipole_B;
} Acting;

bool plant_start(const PlantLaw *plant, const PlantInputs *u, PlantState *x, Fault *f)
{
    (void)u, (void)f;
    *x = (PlantState){.t = 0.0};
    memcpy(x->l_w, plant->h_w0, sizeof x->l_w);
    store_matrix(plant->R_NB0, x->R);
    store(add(apply(plant->body.J, vector(plant->p.omega_B0)),
              plant_wheels_momentum(&plant->body, plant->h_w0, x->angle)),
          x->Pi);
    return true;
}

static Vector dipole_B(const PlantLaw *plant, Vector dipole)
{
    return add(apply(plant->rods_to_body, dipole), vector(plant->p.residual_dipole_B));
}

/* M_g = 3 mu/r^3 r_hat x J r_hat [2], of sqrt(3 mu/r^3) r_hat in body axes. */
static Vector gravity_gradient(const PlantLaw *plant, Vector pull_B)
{
    return cross(pull_B, apply(plant->body.J, pull_B));
}

/* Each plate facing the flow takes the momentum of what strikes it: M = sum (r_i - c) x F_i, F_i = -1/2 rho C_d A_i
 * max(0, v.n_i) v. Omega x r is left out: 0.1 m/s of 7500. Of two plates n and -n, max(0, v.n) (d n - c) + max(0,
 * -v.n) (-d n - c) = d (v.n) n - |v.n| c; over the four pairs of sides the first sums to 2 d (v - (v.e) e), e along
 * the cylinder, and v x v is zero. */
static Vector drag(const PlantLaw *plant, Vector v_B, double density)
{
    static const double root =
        1.41421356237309504880; /* of two: sides at 45 deg see |x + y| + |x - y| = 2 max(|x|, |y|) */
    const Cylinder *body = &plant->cylinder;
    const Vector v = plant_along(body->axis, v_B);
    const double across = fabs(v.y), other = fabs(v.z);
    const double sides = (1.0 + root) * larger(across, other) + smaller(across, other);
    const double flow = density * body->side * sides + density * body->end * fabs(v.x); /* kg/s */
    return subtract(scale(flow, cross(body->center_of_mass, v_B)),
                    scale(density * body->slenderness * v.x, cross(body->along, v_B)));
}

static bool same(const Matrix *R, const Matrix *S)
{
    return R->a.x == S->a.x && R->a.y == S->a.y && R->a.z == S->a.z && R->b.x == S->b.x && R->b.y == S->b.y &&
           R->b.z == S->b.z && R->c.x == S->c.x && R->c.y == S->c.y && R->c.z == S->c.z;
}

/* Valid until the next call. */
static const Loads *loads_at(PlantLaw *plant, const Matrix *R, double t)
{
    Loads *loads = &plant->loads;
    if (loads->known && loads->t == t && same(&loads->R, R)) {
        return loads;
    }
    const Surroundings *around = plant_surroundings_at(&plant->environment, t);
    loads->known = true;
    loads->t = t;
    loads->R = *R;
    loads->b = apply_transposed(*R, around->along.b_N);
    if (plant->p.gravity_gradient) {
        loads->gravity_gradient = gravity_gradient(plant, apply_transposed(*R, around->along.pull_N));
    }
    if (plant->p.drag) {
        loads->drag = drag(plant, apply_transposed(*R, around->along.flow_N), around->density);
    }
    if (plant->p.solar_pressure) {
        loads->solar = plant_solar_pressure(plant, R, t);
    }
    return loads;
}

static Vector external_moment(void *context, const Matrix *R, double t)
{
    const Acting *acting = context;
    const PlantLaw *plant = acting->plant;
    const Loads *loads = loads_at(acting->plant, R, t);
    Vector tau = add(cross(acting->dipole_B, loads->b), vector(plant->p.disturbance_torque_B));
    if (plant->p.gravity_gradient) {
        tau = add(tau, loads->gravity_gradient);
    }
    if (plant->p.drag) {
        tau = add(tau, loads->drag);
    }
    if (plant->p.solar_pressure) {
        tau = add(tau, loads->solar);
    }
    return tau;
}

static void surroundings_ahead(void *context, double t)
{
    const Acting *acting = context;
    (void)plant_surroundings_at(&acting->plant->environment, t);
}

bool plant_step(PlantLaw *plant, PlantState *x, const PlantInputs *u, double h, PlantOutputs *y, Fault *f)
{
    const double ratio = h / plant->p.step_max * (1.0 - 1e-12);
    if (!(ratio <= INTERNAL_STEPS_MAX)) {
        return fault(f, "step_max", plant->p.step_max, "at least a millionth of the communication step");
    }
    if (plant->p.rod_period > 0.0 && !(h / plant->p.rod_period <= INTERNAL_STEPS_MAX)) {
        return fault(f, "rod_period", plant->p.rod_period, "at least a millionth of the communication step");
    }
    const int n = (int)ratio + 1; /* the fewest with which no step is longer than step_max */

    const Vector with_rods = dipole_B(plant, plant_rod_dipoles(&plant->p, u, true));
    const Vector without = vector(plant->p.residual_dipole_B);
    Acting acting = {plant, with_rods};
    const PlantState *now = x; /* ISO C takes no array of an unqualified struct for a const one */
    Attitude attitude = {matrix(now->R), vector(now->Pi)};
    double l_w[PLANT_WHEELS], angle[PLANT_WHEELS], on_time = 0.0;
    memcpy(l_w, now->l_w, sizeof l_w);
    memcpy(angle, now->angle, sizeof angle);
    for (int i = 0; i < n; ++i) {
        double t = x->t + i * (h / n), left = h / n;
        for (Turn turn = plant_turn_at(&plant->p, t); left > 0.0; turn = plant_next_turn(turn)) {
            const double duration = plant_turn_part(&plant->p, turn, t, left);
            acting.dipole_B = turn.on ? with_rods : without;
            on_time += turn.on ? duration : 0.0;
            for (double rest = duration; rest > 0.0;) {
                Segment wheels[PLANT_WHEELS];
                const double part = plant_wheels_part(plant->wheels, l_w, u->wheel_torque_cmd, rest, wheels);
                if (!plant_advance(&plant->body, plant->p.integrator_order, wheels, angle, external_moment,
                                   surroundings_ahead, &acting, t, &attitude, f)) {
                    return false;
                }
                if (plant->body.unbalanced) {
                    plant_imbalance_turned(plant->body.imbalances, wheels, angle, part, angle);
                }
                t += part;
                rest -= part;
                for (int k = 0; k < PLANT_WHEELS; ++k) {
                    l_w[k] = wheels[k].l_end;
                }
            }
            left -= duration;
        }
    }
    PlantState next;
    next.t = x->t + h;
    memcpy(next.l_w, l_w, sizeof next.l_w);
    memcpy(next.angle, angle, sizeof next.angle);
    store(scale(smaller(on_time / h, 1.0), plant_rod_dipoles(&plant->p, u, true)), next.dipole_mean);
    store_matrix(attitude.R, next.R);
    store(attitude.Pi, next.Pi);
    *x = next;
    return plant_outputs(plant, x, u, y, f);
}

/* Scalar first and not negative. Shepperd's method: the largest component is the pivot, so that nothing cancels. */
static void quaternion(Matrix R, double q[4])
{
    const double s[4] = {1.0 + R.a.x + R.b.y + R.c.z, 1.0 + R.a.x - R.b.y - R.c.z, 1.0 - R.a.x + R.b.y - R.c.z,
                         1.0 - R.a.x - R.b.y + R.c.z};
    const double x = R.c.y - R.b.z, y = R.a.z - R.c.x, z = R.b.x - R.a.y;
    const double xy = R.a.y + R.b.x, yz = R.b.z + R.c.y, zx = R.c.x + R.a.z;
    const double candidates[4][4] = {{s[0], x, y, z}, {x, s[1], xy, zx}, {y, xy, s[2], yz}, {z, zx, yz, s[3]}};
    int pivot = 0;
    for (int i = 1; i < 4; ++i) {
        pivot = s[i] > s[pivot] ? i : pivot;
    }
    const double *c = candidates[pivot];
    const double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3]);
    const double factor = c[0] >= 0.0 ? 1.0 / length : -1.0 / length;
    for (int i = 0; i < 4; ++i) {
        q[i] = factor * c[i];
    }
}

bool plant_outputs(PlantLaw *plant, const PlantState *x, const PlantInputs *u, PlantOutputs *y, Fault *f)
{
    (void)f;
    const PlantParameters *p = &plant->p;
    const Matrix R = matrix(x->R), J = plant->body.J;
    const Vector Pi = vector(x->Pi);
    const Vector Omega =
        apply(plant->body.J_inverse, subtract(Pi, plant_wheels_momentum(&plant->body, x->l_w, x->angle)));
    const Loads *loads = loads_at(plant, &R, x->t);
    const OrbitState motion = plant_motion_at(&plant->environment.orbit, x->t);
    const Vector dipole = plant_rod_dipoles(p, u, plant_turn_at(p, x->t).on), H_N = apply(R, Pi);

    store_matrix(R, y->R_NB);
    store(Omega, y->omega_B);
    store(motion.r, y->r_N);
    store(motion.v, y->v_N);
    store(loads->b, y->b_B);
    quaternion(R, y->q_NB);
    store(H_N, y->H_N);
    y->energy = 0.5 * dot(Omega, apply(J, Omega));
    store(loads->gravity_gradient, y->tau_gg_B);
    if (p->gravity_gradient) {
        /* With U and the turning of the orbit, which is conserved on a circle. */
        const double r = norm(motion.r);
        const double rate_squared = p->gravitational_parameter / (r * r * r);
        const Vector r_hat_B = scale(1.0 / r, apply_transposed(R, motion.r));
        y->energy += rate_squared * (1.5 * dot(r_hat_B, apply(J, r_hat_B)) - 0.5 * (J.a.x + J.b.y + J.c.z));
        y->energy -= dot(cross(motion.r, motion.v), H_N) / (r * r);
    }
    y->density = plant_surroundings_at(&plant->environment, x->t)->density;
    store(loads->drag, y->tau_drag_B);
    store(cross(dipole_B(plant, dipole), loads->b), y->tau_mag_B);
    store(dipole, y->dipole);
    store(vector(x->dipole_mean), y->dipole_mean);
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        const double command = u->wheel_torque_cmd[i];
        y->h_w[i] = x->l_w[i];
        y->wheel_torque[i] =
            plant_wheel_net_torque(&plant->wheels[i], x->l_w[i], command, &y->wheel_momentum_saturated[i]);
        y->wheel_torque_saturated[i] = i < plant->count && fabs(command) > p->wheel_torque_max[i];
        y->wheel_speed[i] = x->l_w[i] / p->wheel_inertia[i];
    }
    y->field_extrapolated = plant->field_extrapolated;
    (void)plant_see_sun(&plant->environment.sun, x->t, &motion.r, y->sun_N, &y->sunlight);
    y->dipole_saturated = false;
    for (int i = 0; i < 3; ++i) {
        y->dipole_saturated = y->dipole_saturated || fabs(u->dipole_cmd[i]) > p->dipole_max * p->rod_limits[i];
    }
    return true;
}
