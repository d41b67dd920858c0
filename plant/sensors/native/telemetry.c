/* Telemetry of the wheels and the rods. Tests: tests/native/test_flavours.py. */
#include "models.h"

void plant_sensors_telemetry(const PlantSensorsParameters *p, int64_t sample, const PlantSensorsInputs *u,
                             PlantSensorsOutputs *y)
{
    for (int i = 0; i < PLANT_SENSORS_WHEELS; ++i) {
        double pair[2] = {0.0, 0.0};
        if (p->wheel_momentum_noise > 0.0) {
            plant_sensors_normal_pair((Draw){p->seed, sample, WHEEL_NOISE}, (uint32_t)i / 2, pair);
        }
        y->h_w_measured[i] = u->h_w[i] + p->wheel_momentum_noise * pair[i % 2];
#if PLANT_SENSORS_WHEELS > 1
        y->h_w_measured[i] += p->wheel_momentum_bias[i];
#endif
    }
    store((Vector){0.0, 0.0, 0.0}, y->dipole_measured);
    if (plant_sensors_has_dipole(u)) {
        const Draw draw = {p->seed, sample, DIPOLE_NOISE};
        store(add(vector(u->dipole), sensor_noise(draw, p->dipole_noise)), y->dipole_measured);
    }
}
