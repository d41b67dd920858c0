/* Least squares of a few unknowns in a box, by its normal equations: minimise x^T H x / 2 - g^T x, low <= x <= high. */
#ifndef ALLOCATOR_BOUNDED_BOX_H
#define ALLOCATOR_BOUNDED_BOX_H

#include <stdbool.h>

#include "allocator_bounded_ports.h"

enum { BOX_N = 3 + ALLOCATOR_BOUNDED_WHEELS };

typedef struct {
    int n;                  /* unknowns, at most BOX_N */
    double H[BOX_N][BOX_N]; /* symmetric, positive definite */
    double g[BOX_N];
    double low[BOX_N], high[BOX_N]; /* low < high */
} Box;

/* The minimum in the box, exact to rounding, and the one that there is without the box, `unbounded`.
 * Tries the 3^n faces of the box at most. False where a number overflowed; x is then not set. */
bool allocator_bounded_box_minimum(const Box *box, double x[BOX_N], double unbounded[BOX_N]);

#endif
