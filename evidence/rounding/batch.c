/* Many samples in one call: the block is started with the inputs before, then asked for its outputs. */
#include "block.h"

#include <math.h>
#include <stddef.h>

#define CALLED __attribute__((visibility("default")))

CALLED size_t batch(const Parameters *p, const Inputs *u, size_t n, Outputs *y);
CALLED void batch_atan2(const double *y, const double *x, size_t n, double *angle);
CALLED void batch_log1p(const double *x, size_t n, double *logarithm);

/* Writes n outputs of n + 1 inputs; returns at which it was refused, n where none was. */
size_t batch(const Parameters *p, const Inputs *u, size_t n, Outputs *y)
{
    static Law law;
    Fault f = {"", "", NULL, 0.0};
    State x;
    if (!block_check(p, &f)) {
        return 0;
    }
    block_prepare(p, &law);
    for (size_t i = 0; i < n; ++i) {
        if (!block_start(&law, &u[i], &x, &f) || !block_outputs(&law, &x, &u[i + 1], &y[i], &f)) {
            return i;
        }
    }
    return n;
}

void batch_atan2(const double *y, const double *x, size_t n, double *angle)
{
    for (size_t i = 0; i < n; ++i) {
        angle[i] = atan2(y[i], x[i]);
    }
}

void batch_log1p(const double *x, size_t n, double *logarithm)
{
    for (size_t i = 0; i < n; ++i) {
        logarithm[i] = log1p(x[i]);
    }
}
