/* Telemetry of the wheel and the rods. Tests: tests/native/test_flavours.py. */
#include "models.h"

void plant_sensors_telemetry(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u,
                             PlantSensorsOutputs *y)
{
    y->h_w_measured = u->h_w + sensor_noise((Draw){p->seed, sample, WHEEL_NOISE}, p->wheel_momentum_noise).x;
    store((Vector){0.0, 0.0, 0.0}, y->dipole_measured);
    if (plant_sensors_has_dipole(u)) {
        const Draw draw = {p->seed, sample, DIPOLE_NOISE};
        store(add(vector(u->dipole), sensor_noise(draw, p->dipole_noise)), y->dipole_measured);
    }
}
