/* Standard normal numbers as a function of where they are used. */
#ifndef PLANT_SENSORS_NOISE_H
#define PLANT_SENSORS_NOISE_H

#include <stdint.h>

typedef struct {
    uint32_t word[4];
} Words;

/* Philox 4x32-10 (Salmon, Moraes, Dror and Shaw, SC11, 2011): the random words of a counter under a key. */
Words plant_sensors_philox(Words counter, uint32_t key_low, uint32_t key_high);

/* Two independent standard normal numbers by Box and Muller (1958), of one pair of axes of a sensor's measurement. */
void plant_sensors_normal_pair(int32_t seed, int64_t sample, uint32_t sensor, uint32_t pair, double out[2]);

#endif
