/* Whether numbers are finite, as Frama-C's WP proves it: the guards through which outputs leave a block.
 * Requirement: FC-4. Tests: tests/native/test_calls.py. */
#ifndef COMMON_FINITE_H
#define COMMON_FINITE_H

#include <float.h>
#include <stdbool.h>
#include <stddef.h>

#include "fault.h"

/*@ assigns \nothing;
    ensures \result ==> \is_finite(x); */
static inline bool is_number(double x)
{
    return x >= -DBL_MAX && x <= DBL_MAX;
}

/* What is proved of it holds for all. */
/*@ axiomatic Any { logic integer any_place; } */

/* Whether each of n numbers is finite; it goes through all of them, so a compiler takes several at a time. */
/*@ assigns \nothing;
    ensures \result && 0 <= any_place < n ==> \is_finite(x[any_place]); */
static inline bool run_finite(const double *x, size_t n)
{
    bool all = true;
    /*@ loop invariant 0 <= i <= n;
        loop invariant all && 0 <= any_place < i ==> \is_finite(x[any_place]);
        loop assigns i, all; */
    for (size_t i = 0; i < n; ++i) {
        if (!is_number(x[i])) {
            all = false;
        }
        //@ assert any_place == i && all ==> \is_finite(x[any_place]);
        //@ assert all && 0 <= any_place < i + 1 ==> \is_finite(x[any_place]);
        //@ assert i + 1 <= n <= SIZE_MAX;
    }
    return all;
}

/* Notes the first of n numbers that is not finite, by the name of their variable; false. */
/*@ assigns *f;
    ensures !\result; */
static inline bool not_finite(const double *x, size_t n, const char *name, Fault *f)
{
    //@ loop assigns i;
    for (size_t i = 0; i < n; ++i) {
        if (!is_number(x[i])) {
            return fault(f, name, x[i], "finite numbers for this output");
        }
    }
    return false;
}

#endif
