/* Sun sensors: coarse ones by the cosine law with the Earth's albedo, the sun vector made of them, and a fine one.
 * Tests: tests/native/test_flavours.py. */
#include "models.h"
#include "rotation.h"

static const double PI = 3.14159265358979323846;
static const double RIDGE = 1e-5; /* of a unit axis: the shortest of all least-squares solutions */

/* From a small plate to the whole of a sphere, H >= 1 of its radii from its centre; c: cosine of normal and centre.
 * Cunningham, NASA TN D-710 (1961). */
static double view_factor(double c, double H)
{
    if (c * H >= 1.0) {
        return c / (H * H);
    }
    if (c * H <= -1.0) {
        return 0.0;
    }
    const double m = sqrt(H * H - 1.0), q = sqrt(larger(1.0 - H * H * c * c, 0.0)); /* the plate's horizon crosses it */
    return 0.5 - atan2(m, q) / PI + (c * atan2(q, -m * c) - m * q) / (PI * H * H);
}

static void signals(const PlantSensorsLaw *law, int64_t sample, Vector s_B, double sunlight, Vector r_B,
                    double x[SUN_SENSORS])
{
    const PlantSensorsParameters *p = &law->p;
    double lit = 0.0, H = 1.0, noise[2] = {0.0, 0.0};
    Vector up_B = {0.0, 0.0, 0.0};
    if (p->albedo > 0.0) {
        const double r = norm(r_B);
        up_B = scale(1.0 / r, r_B);
        lit = p->albedo * larger(dot(up_B, s_B), 0.0);
        H = larger(r / PLANT_SENSORS_EARTH_RADIUS, 1.0);
    }
    for (int i = 0; i < SUN_SENSORS; ++i) {
        const Vector axis = law->sun_axes[i];
        const double cosine = dot(axis, s_B);
        x[i] = cosine >= law->cos_sun_sensor ? sunlight * cosine : 0.0;
        if (p->albedo > 0.0) {
            x[i] += lit * view_factor(-dot(axis, up_B), H);
        }
        if (p->sun_sensor_noise > 0.0) {
            if (i % 2 == 0) {
                plant_sensors_normal_pair((Draw){p->seed, sample, SUN_SENSORS_NOISE}, (uint32_t)(i / 2), noise);
            }
            x[i] += p->sun_sensor_noise * noise[i % 2];
        }
        x[i] = dot(axis, axis) > 0.0 ? x[i] : 0.0;
    }
}

/* x with A x = b, A symmetric and positive definite: Cholesky's method, which keeps its digits where A is next to
 * singular. */
static Vector solve_definite(Matrix A, Vector b)
{
    const double ba = A.b.x / A.a.x, ca = A.c.x / A.a.x;
    const double bb = A.b.y - ba * A.b.x, cb = (A.c.y - ca * A.b.x) / bb;
    const double cc = A.c.z - ca * A.c.x - cb * cb * bb;
    const double y = b.y - ba * b.x;
    const double z = (b.z - ca * b.x - cb * y) / cc;
    const double middle = y / bb - cb * z;
    return (Vector){b.x / A.a.x - ba * middle - ca * z, middle, z};
}

/* By least squares of the sensors on the side of sum n_i x_i, since the others see albedo alone. */
static Vector least_squares(const PlantSensorsLaw *law, const double x[SUN_SENSORS])
{
    Vector towards = {0.0, 0.0, 0.0}, sum = {0.0, 0.0, 0.0};
    Matrix normal = {{RIDGE, 0.0, 0.0}, {0.0, RIDGE, 0.0}, {0.0, 0.0, RIDGE}};
    for (int i = 0; i < SUN_SENSORS; ++i) {
        towards = add(towards, scale(larger(x[i], 0.0), law->sun_axes[i]));
    }
    for (int i = 0; i < SUN_SENSORS; ++i) {
        const Vector n = law->sun_axes[i];
        if (dot(n, towards) > 0.0) {
            normal.a = add(normal.a, scale(n.x, n));
            normal.b = add(normal.b, scale(n.y, n));
            normal.c = add(normal.c, scale(n.z, n));
            sum = add(sum, scale(x[i], n));
        }
    }
    const Vector found = solve_definite(normal, sum);
    const double length = norm(found);
    return length >= law->p.sun_threshold ? scale(1.0 / length, found) : (Vector){0.0, 0.0, 0.0};
}

static Vector fine(const PlantSensorsLaw *law, int64_t sample, Vector s_B, double sunlight)
{
    if (sunlight < law->p.sun_threshold || dot(law->fine_sun_axis, s_B) < law->cos_fine_sun) {
        return (Vector){0.0, 0.0, 0.0};
    }
    const Draw draw = {law->p.seed, sample, FINE_SUN_NOISE};
    return apply(rotation_exp(sensor_noise(draw, law->p.fine_sun_noise)), s_B);
}

bool plant_sensors_sun(const PlantSensorsLaw *law, int64_t sample, const PlantSensorsInputs *u, PlantSensorsOutputs *y)
{
    const Matrix R = matrix(u->R_NB);
    const Vector s_B = apply_transposed(R, vector(u->sun_N)), r_B = apply_transposed(R, vector(u->r_N));
    const double sunlight = plant_sensors_sunlight(u);
    signals(law, sample, s_B, sunlight, r_B, y->sun_sensors);
    const Vector found = law->p.sun_sensor == PLANT_SENSORS_SUN_SENSOR_COARSE ? least_squares(law, y->sun_sensors)
                                                                              : fine(law, sample, s_B, sunlight);
    store(found, y->sun_B_measured);
    return dot(found, found) > 0.0;
}
