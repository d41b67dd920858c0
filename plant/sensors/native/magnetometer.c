/* The magnetometer, with the field of the rods beside it. Tests: tests/native/test_flavours.py. */
#include "models.h"
#include "three_axis.h"

Vector plant_sensors_field(const PlantSensorsLaw *law, int64_t sample, const PlantSensorsInputs *u)
{
    const PlantSensorsParameters *p = &law->p;
    Vector field = vector(u->b_B);
    if (!law->has_field_error) {
        return field;
    }
    const Vector error =
        add(vector(p->field_bias_B), sensor_noise((Draw){p->seed, sample, FIELD_NOISE}, p->field_noise));
    if (law->has_rod_coupling && plant_sensors_has_dipole(u)) {
        field = add(field, apply(matrix(p->field_rod_coupling), vector(u->dipole)));
    }
    if (law->has_field_scale) {
        field = scaled(p->field_scale, field);
    }
    return digitised(add(field, error), p->field_range, p->field_quantum);
}
