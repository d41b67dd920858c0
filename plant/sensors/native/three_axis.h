/* The common part of gyro and magnetometer: scale-factor errors, misalignments, range and resolution. */
#ifndef PLANT_SENSORS_THREE_AXIS_H
#define PLANT_SENSORS_THREE_AXIS_H

#include <stdint.h>

#include "vector.h"

/* (I + S) x. */
static inline Vector scaled(const double S[3][3], Vector x)
{
    return add(x, apply(matrix(S), x));
}

/* The nearest multiple, halves upwards; from 2^52 quanta on every number is one. */
static inline double rounded(double x, double quantum)
{
    const double n = x / quantum + 0.5;
    if (!(fabs(x / quantum) < 0x1p52)) {
        return x;
    }
    const double whole = (double)(int64_t)n;
    return quantum * (whole > n ? whole - 1.0 : whole);
}

/* Clipped at +-limit and rounded to multiples of quantum; 0 switches either off. */
static inline Vector digitised(Vector x, double limit, double quantum)
{
    if (limit > 0.0) {
        x = (Vector){clip(x.x, -limit, limit), clip(x.y, -limit, limit), clip(x.z, -limit, limit)};
    }
    if (quantum > 0.0) {
        x = (Vector){rounded(x.x, quantum), rounded(x.y, quantum), rounded(x.z, quantum)};
    }
    return x;
}

#endif
