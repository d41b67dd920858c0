/* The plant's parameters: their check, and what follows from them alone. */
#include "plant.h"
#include "rotation.h"
#include "time_scales.h"

static const double LOWEST_PERIGEE = WGS84_RADIUS + 100e3; /* m; below it the orbit is no orbit */
enum { DRIFT_PASSES = 6 };

static Matrix inertia(const PlantParameters *p)
{
    const Matrix J = matrix(p->J_B), error = matrix(p->J_error_B);
    return (Matrix){add(J.a, error.a), add(J.b, error.b), add(J.c, error.c)};
}

/* v_N0 contains the turning of the orbit's plane, whose rate follows from the orbit in the plane: a fixed point, of
 * which each pass leaves about a thousandth of the error. */
static bool drifting_orbit_through(const PlantParameters *p, Orbit *orbit)
{
    const Vector r = vector(p->r_N0), v = vector(p->v_N0);
    const double mu = p->gravitational_parameter;
    double rate = 0.0;
    for (int pass = 0; pass < DRIFT_PASSES; ++pass) {
        rate = plant_j2_node_rate(orbit, mu);
        if (!plant_orbit_through(r, subtract(v, scale(rate, (Vector){-r.y, r.x, 0.0})), mu, orbit)) {
            return false;
        }
    }
    orbit->node_rate = rate;
    return true;
}

static bool orbit_of(const PlantParameters *p, const Epoch *date, Orbit *orbit, Fault *f)
{
    const double mu = p->gravitational_parameter;
    if (p->orbit_start == PLANT_ORBIT_START_POSITION_VELOCITY) {
        const Vector r = vector(p->r_N0), v = vector(p->v_N0);
        if (norm(r) == 0.0) {
            return fault(f, "r_N0", 0.0, "a position away from the Earth's centre");
        }
        if (!plant_orbit_through(r, v, mu, orbit) || (p->j2_node_drift && !drifting_orbit_through(p, orbit))) {
            return fault(f, "v_N0", norm(v),
                         "below escape speed and not along r_N0 (this is |v_N0|), so that they give an orbit");
        }
        return true;
    }
    *orbit = plant_circular_orbit(p->orbit_radius, p->inclination, epoch_sidereal_angle(date) + p->node_longitude,
                                  p->argument_of_latitude, mu);
    orbit->node_rate = p->j2_node_drift ? plant_j2_node_rate(orbit, mu) : 0.0;
    return true;
}

static bool is_above_ground(const PlantParameters *p, const Orbit *orbit, Fault *f)
{
    const char *name = p->orbit_start == PLANT_ORBIT_START_CIRCULAR ? "orbit_radius" : "r_N0, v_N0";
    const double a = orbit->semi_major_axis, e = orbit->eccentricity;
    if (!(a * (1.0 - e) >= LOWEST_PERIGEE)) {
        return fault(f, name, a * (1.0 - e), "a perigee of at least 6478137 m, 100 km above the equator");
    }
    if (p->drag) {
        const double lowest = a * (1.0 - e) - WGS84_RADIUS;
        const double highest = a * (1.0 + e) - WGS84_RADIUS * (1.0 - WGS84_FLATTENING);
        static const char *const expected = "heights of 150 km to 2000 km, where the density is known, or drag false";
        if (!(lowest >= AIR_LOWEST)) {
            return fault(f, name, lowest, expected);
        }
        if (!(highest <= AIR_HIGHEST)) {
            return fault(f, name, highest, expected);
        }
    }
    return true;
}

static bool is_attitude(const PlantParameters *p, Fault *f)
{
    if (p->initial_attitude == PLANT_INITIAL_ATTITUDE_Q0) {
        return is_rotation(matrix(p->Q0), 1e-3, "Q0", "a rotation matrix, max |Q0^T Q0 - I| at most 0.001", f);
    }
    const double *q = p->q_NB0;
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(fabs(length - 1.0) <= 1e-3)) {
        return fault(f, "q_NB0", length, "a quaternion of unit length, to 0.001");
    }
    return true;
}

static bool is_inside(const PlantParameters *p, Fault *f)
{
    static const char *const names[] = {"center_of_mass_B[1]", "center_of_mass_B[2]", "center_of_mass_B[3]"};
    for (int i = 0; i < 3; ++i) {
        const double size = p->body_axis == i + 1 ? p->body_length : p->body_width;
        if (!(fabs(p->center_of_mass_B[i]) <= 0.5 * size)) {
            return fault(f, names[i], p->center_of_mass_B[i],
                         "inside the body, within half of body_length or body_width");
        }
    }
    return true;
}

static bool covers(const FieldModel *model, double year)
{
    return year >= model->years[0] && year <= model->valid_until;
}

static bool check_field(const PlantParameters *p, const Epoch *date, Fault *f)
{
    const FieldModel *model = &plant_field_models[p->field_model - 1];
    const double year = plant_decimal_year(date);
    if (p->field_degree < 1 || p->field_degree > FIELD_DEGREE_MAX) {
        return fault(f, "field_degree", p->field_degree, "1 to 13");
    }
    if (!p->field_extrapolate && !covers(model, year)) {
        return fault(f, "epoch", year, model->covered);
    }
    return true;
}

bool plant_check(const PlantParameters *p, Fault *f)
{
    Epoch date;
    Orbit orbit;
    if (!is_inertia(matrix(p->J_B), "J_B", f) || !is_inertia(inertia(p), "J_B + J_error_B", f) ||
        !has_unit_rows(matrix(p->rod_axes), "rod_axes", f) || !plant_check_wheels(p, f) ||
        !are_rod_limits(p->rod_limits, f)) {
        return false;
    }
    static const char *const gains[] = {"rod_gain[1]", "rod_gain[2]", "rod_gain[3]"};
    for (int i = 0; i < 3; ++i) {
        if (!(p->rod_gain[i] >= -2.0 && p->rod_gain[i] <= 2.0)) {
            return fault(f, gains[i], p->rod_gain[i], "-2 to 2");
        }
    }
    if (!(p->rod_period == 0.0 || p->rod_period >= 1e-3)) {
        return fault(f, "rod_period", p->rod_period, "0 (always on) or at least 0.001 s");
    }
    if (!(p->rod_duty >= 0.0 && p->rod_duty <= 1.0)) {
        return fault(f, "rod_duty", p->rod_duty, "0 to 1");
    }
    if (!(p->solar_specular + p->solar_diffuse <= 1.0)) {
        return fault(f, "solar_specular + solar_diffuse", p->solar_specular + p->solar_diffuse, "at most 1");
    }
    if (p->integrator_order != 2 && p->integrator_order != 4 && p->integrator_order != 6) {
        return fault(f, "integrator_order", p->integrator_order, "2, 4 or 6");
    }
    return is_attitude(p, f) && is_epoch(p->epoch, &date, f) && orbit_of(p, &date, &orbit, f) &&
           is_above_ground(p, &orbit, f) && (!(p->drag || p->solar_pressure) || is_inside(p, f)) &&
           check_field(p, &date, f);
}

/* Width across the flats. */
static Cylinder cylinder_of(const PlantParameters *p)
{
    static const double edge = 0.41421356237309504880; /* of the width: tan 22.5 deg */
    const double coefficient = 0.5 * p->drag_factor * p->drag_coefficient;
    const double side = coefficient * edge * p->body_width * p->body_length;
    const double end = 2.0 * coefficient * edge * p->body_width * p->body_width;
    const Vector axes[] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    return (Cylinder){p->body_axis,
                      axes[p->body_axis - 1],
                      side,
                      end,
                      0.5 * end * p->body_length - side * p->body_width,
                      vector(p->center_of_mass_B)};
}

/* The rotation of a quaternion, scalar first. */
static Matrix from_quaternion(const double q[4])
{
    const double s = 2.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return (Matrix){{1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
                    {s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)},
                    {s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)}};
}

void plant_prepare(const PlantParameters *p, PlantLaw *plant)
{
    Epoch date = {0, 0, 0, 1};
    Fault unused;
    Environment *environment = &plant->environment;

    plant->p = *p;
    const Matrix J = inertia(p), K = inverse(J);
    plant->body = (Body){.J = J,
                         .J_inverse = K,
                         .J_twice = {add(J.a, J.a), add(J.b, J.b), add(J.c, J.c)},
                         .compliance = 0.5 * (K.a.x + K.b.y + K.c.z)};
    plant_prepare_wheels(p, plant);
    plant->rods_to_body = transposed(with_unit_rows(matrix(p->rod_axes)));
    plant->cylinder = cylinder_of(p);

    (void)epoch_read(p->epoch, &date);
    (void)orbit_of(p, &date, &environment->orbit, &unused);
    environment->mu = p->gravitational_parameter;
    environment->gmst0 = epoch_sidereal_angle(&date);
    environment->day0 = plant_day_of_year(&date);
    environment->sun.days = epoch_days_since_j2000(&date);
    const FieldModel *model = &plant_field_models[p->field_model - 1];
    environment->field = plant_field_of(model, plant_decimal_year(&date), p->field_degree);
    plant->field_extrapolated = !covers(model, plant_decimal_year(&date));
    environment->has_air = p->drag;
    environment->activity = plant_activity_of(p->f107, p->f107_average, p->ap);
    plant_forget_surroundings(environment);
    plant->loads = (Loads){.known = false};

    const OrbitState start = plant_motion_at(&environment->orbit, 0.0);
    plant->R_NB0 = p->initial_attitude == PLANT_INITIAL_ATTITUDE_Q_NB0
                       ? from_quaternion(p->q_NB0)
                       : multiply(lvlh_axes(start.r, start.v), nearest_rotation(matrix(p->Q0)));
}
