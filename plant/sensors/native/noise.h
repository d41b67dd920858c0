/* Standard normal numbers as a function of where they are used. */
#ifndef PLANT_SENSORS_NOISE_H
#define PLANT_SENSORS_NOISE_H

#include <stdint.h>

#include "vector.h"

/* The sensor that draws noise; each has a stream of its own. */
enum {
    ATTITUDE_NOISE,
    RATE_NOISE,
    FIELD_NOISE,
    WHEEL_NOISE,
    POSITION_NOISE,
    VELOCITY_NOISE,
    DIPOLE_NOISE,
    SUN_SENSORS_NOISE,
    FINE_SUN_NOISE,
    RATE_WALK_NOISE,
    RATE_INSTABILITY_NOISE,
    ATTITUDE_LOSS_NOISE,
    ORBIT_LOSS_NOISE
};

/* Where a sensor's measurement draws its noise. */
typedef struct {
    int32_t seed;
    int64_t sample;
    uint32_t sensor;
} Draw;

typedef struct {
    uint32_t word[4];
} Words;

/* Philox 4x32-10 (Salmon, Moraes, Dror and Shaw, SC11, 2011): the random words of a counter under a key. */
Words plant_sensors_philox(Words counter, uint32_t key_low, uint32_t key_high);

/* Two independent standard normal numbers by Box and Muller (1958), of one pair of axes. */
void plant_sensors_normal_pair(Draw draw, uint32_t pair, double out[2]);

/* Independent standard normal numbers on three axes. */
Vector plant_sensors_normals(Draw draw);

/* Of standard deviation sigma; zeros, without drawing any, where sigma is zero. */
static inline Vector sensor_noise(Draw draw, double sigma)
{
    return sigma > 0.0 ? scale(sigma, plant_sensors_normals(draw)) : (Vector){0.0, 0.0, 0.0};
}

/* A number evenly distributed in (0, 1). */
double plant_sensors_uniform(Draw draw);

#endif
