/* Tests: tests/plant/test_solar_pressure.py, tests/native/test_plant.py. */
#include "solar_pressure.h"

static const double AU = 149597870700.0;             /* m */
static const double PRESSURE = 1361.0 / 299792458.0; /* N/m2, at one AU: nominal irradiance (IAU 2015 B3) over c */
static const double ROOT_HALF = 0.70710678118654752440;

/* Undoes plant_along. */
static Vector to_body(int32_t axis, Vector v)
{
    switch (axis) {
    case PLANT_BODY_AXIS_X:
        return v;
    case PLANT_BODY_AXIS_Y:
        return (Vector){v.z, v.x, v.y};
    default:
        return (Vector){v.y, v.z, v.x};
    }
}

/* Of two plates with the normals n and -n, one is lit: F = -p A [(1 - specular) s + 2 (specular n.s + diffuse/3) n] n.s
 * at d n, with n turned to the light (Wertz, 17.2.2). d n x n is zero. */
static Vector pair(const PlantParameters *p, Vector n, double area, double d, Vector sun, Vector center)
{
    const double projected = dot(n, sun), lit = fabs(projected);
    const Vector facing = projected < 0.0 ? scale(-1.0, n) : n;
    const double along_normal = 2.0 * (p->solar_specular * lit + p->solar_diffuse / 3.0);
    const Vector force = add(scale(1.0 - p->solar_specular, sun), scale(along_normal, facing));
    return scale(-area * lit, cross(subtract(scale(d, facing), center), force));
}

Vector plant_solar_pressure(PlantLaw *plant, const Matrix *R, double t)
{
    const PlantParameters *p = &plant->p;
    const OrbitState motion = plant_motion_at(&plant->environment.orbit, t);
    double sun_N[3], sunlight;
    const double distance = plant_see_sun(&plant->environment.sun, t, &motion.r, sun_N, &sunlight);
    if (sunlight <= 0.0) {
        return (Vector){0.0, 0.0, 0.0};
    }
    static const Vector normals[] = {
        {0.0, 1.0, 0.0}, {0.0, ROOT_HALF, ROOT_HALF}, {0.0, 0.0, 1.0}, {0.0, -ROOT_HALF, ROOT_HALF}};
    static const double EDGE = 0.41421356237309504880; /* of the width: tan 22.5 deg */
    const Vector sun = plant_along(p->body_axis, apply_transposed(*R, vector(sun_N)));
    const Vector center = plant_along(p->body_axis, vector(p->center_of_mass_B));
    const double side = EDGE * p->body_width * p->body_length, end = 2.0 * EDGE * p->body_width * p->body_width;
    Vector moment = pair(p, (Vector){1.0, 0.0, 0.0}, end, 0.5 * p->body_length, sun, center);
    for (int i = 0; i < 4; ++i) {
        moment = add(moment, pair(p, normals[i], side, 0.5 * p->body_width, sun, center));
    }
    return to_body(p->body_axis, scale(PRESSURE * AU / distance * (AU / distance) * sunlight, moment));
}
