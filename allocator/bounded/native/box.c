/* The least of a quadratic within a box, by its faces. Requirement: AB-1. */
#include "box.h"

#include <float.h>
#include <math.h>

#include "vector.h"

enum { FREE, LOW, HIGH };

/* The minimum over x with its elements free or at their bounds, by elimination; H needs no pivots. */
static void minimum_on_face(const Box *box, const int side[BOX_N], double x[BOX_N])
{
    double a[BOX_N][BOX_N], y[BOX_N];
    int index[BOX_N] = {0}, n = 0;
    //@ loop unroll BOX_N;
    for (int i = 0; i < box->n; ++i) {
        if (side[i] == FREE) {
            index[n++] = i;
        } else {
            x[i] = side[i] == LOW ? box->low[i] : box->high[i];
        }
    }
    //@ split n;
    for (int i = 0; i < n; ++i) {
        y[i] = box->g[index[i]];
        for (int k = 0; k < box->n; ++k) {
            if (side[k] != FREE) {
                y[i] -= box->H[index[i]][k] * x[k];
            }
        }
        for (int j = 0; j < n; ++j) {
            a[i][j] = box->H[index[i]][index[j]];
        }
    }
    for (int k = 0; k < n; ++k) {
        for (int i = k + 1; i < n; ++i) {
            const double factor = a[i][k] / a[k][k];
            for (int j = k + 1; j < n; ++j) {
                a[i][j] -= factor * a[k][j];
            }
            y[i] -= factor * y[k];
        }
    }
    for (int i = n - 1; i >= 0; --i) {
        for (int j = i + 1; j < n; ++j) {
            y[i] -= a[i][j] * y[j];
        }
        y[i] /= a[i][i];
        x[index[i]] = y[i];
    }
}

/* By how much x violates the conditions of optimality, in units of x: a free element is outside the box, or the
 * gradient pushes one from its bound inwards, where it alone would move by gradient/H_ii. Where it is `enough` or more,
 * not all elements are looked at. */
static double violation(const Box *box, const int side[BOX_N], const double x[BOX_N], double enough)
{
    double largest_one = -INFINITY;
    for (int i = 0; i < box->n && !(largest_one >= enough); ++i) {
        double one = larger(box->low[i] - x[i], x[i] - box->high[i]);
        if (side[i] != FREE) {
            double gradient = -box->g[i];
            for (int k = 0; k < box->n; ++k) {
                gradient += box->H[i][k] * x[k];
            }
            one = (side[i] == HIGH ? gradient : -gradient) / box->H[i][i];
        }
        if (!(one <= largest_one)) { /* also where it is no number */
            largest_one = one;
        }
    }
    return largest_one;
}

/* The next of the 3^n faces: the last side counts fastest. */
static void following(int n, int side[BOX_N])
{
    for (int i = n - 1; i >= 0; --i) {
        side[i] = side[i] == FREE ? LOW : side[i] == LOW ? HIGH : FREE;
        if (side[i] != FREE) {
            break;
        }
    }
}

bool allocator_bounded_box_minimum(const Box *box, double x[BOX_N], double unbounded[BOX_N])
{
    double least = DBL_MAX, candidate[BOX_N] = {0.0};
    int faces = 1, side[BOX_N] = {FREE};
    for (int i = 0; i < box->n; ++i) {
        faces *= 3;
    }
    for (int face = 0; face < faces && least > 0.0; ++face) {
        minimum_on_face(box, side, candidate);
        const double found = violation(box, side, candidate, least);
        if (found < least) {
            least = found;
            for (int i = 0; i < box->n; ++i) {
                x[i] = larger(smaller(candidate[i], box->high[i]), box->low[i]);
            }
        }
        if (face == 0) { /* all are free */
            for (int i = 0; i < box->n; ++i) {
                unbounded[i] = candidate[i];
            }
        }
        following(box->n, side);
    }
    return least < DBL_MAX || box->n == 0;
}
