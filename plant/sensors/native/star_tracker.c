/* The star tracker: noise about and across its boresight, and when it sees no stars.
 * Tests: tests/native/test_flavours.py. */
#include "models.h"
#include "rotation.h"

static const double PI = 3.14159265358979323846;

bool plant_sensors_sees_stars(const PlantSensorsLaw *law, const PlantSensorsInputs *u)
{
    const PlantSensorsParameters *p = &law->p;
    const Vector omega = vector(u->omega_B), r = vector(u->r_N);
    if (p->attitude_rate_max > 0.0 && dot(omega, omega) > p->attitude_rate_max * p->attitude_rate_max) {
        return false;
    }
    if (!(p->attitude_sun_exclusion > 0.0) && !(p->attitude_earth_exclusion > 0.0)) {
        return true;
    }
    const Vector towards_N = apply(matrix(u->R_NB), law->boresight);
    if (p->attitude_sun_exclusion > 0.0 && plant_sensors_has_sun_N(u) && plant_sensors_sunlight(u) > 0.0 &&
        dot(towards_N, vector(u->sun_N)) > law->cos_sun_exclusion) {
        return false;
    }
    if (p->attitude_earth_exclusion > 0.0) {
        const double radius = norm(r), s = smaller(PLANT_SENSORS_EARTH_RADIUS / radius, 1.0);
        const double limb = atan2(s, sqrt(1.0 - s * s)); /* from nadir */
        return !(dot(towards_N, r) < -radius * cos(smaller(limb + p->attitude_earth_exclusion, PI)));
    }
    return true;
}

/* R_NB exp(delta^). */
Matrix plant_sensors_attitude(const PlantSensorsLaw *law, int64_t sample, const PlantSensorsInputs *u)
{
    const PlantSensorsParameters *p = &law->p;
    if (!law->turns_attitude) {
        return matrix(u->R_NB);
    }
    const Draw draw = {p->seed, sample, ATTITUDE_NOISE};
    const double across = p->attitude_noise, about = p->attitude_noise_about;
    Vector turn = vector(p->attitude_bias_B);
    if (about > 0.0) {
        const Vector xi = plant_sensors_normals(draw);
        turn = add(turn, add(scale(across, xi), scale((about - across) * dot(law->boresight, xi), law->boresight)));
    } else {
        turn = add(turn, sensor_noise(draw, across));
    }
    return multiply(matrix(u->R_NB), rotation_exp(turn));
}
