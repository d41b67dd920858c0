/* An error of a value: names and expectation are literals, so a law formats no text. */
#ifndef COMMON_FAULT_H
#define COMMON_FAULT_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct {
    const char *name;     /* of the variable, with its element where one stands out: "K0[2]" */
    const char *expected; /* "0 < K0[1] < K0[2] < K0[3]" */
    const char *text;     /* the value found where it is text, else NULL */
    double value;         /* the value found */
} Fault;

/* Notes the fault; false, so that a check can end with `return fault(...)`. */
/*@ assigns *f, \result \from name, value, expected;
    ensures !\result; */
static inline bool fault(Fault *f, const char *name, double value, const char *expected)
{
    f->name = name;
    f->expected = expected;
    f->text = NULL;
    f->value = value;
    return false;
}

typedef struct {
    const char *name;
    double value;
} Named;

/* Whether each value is a finite number above 0. */
static inline bool all_positive(const Named *values, size_t n, Fault *f)
{
    for (size_t i = 0; i < n; ++i) {
        if (!(values[i].value > 0.0 && isfinite(values[i].value))) {
            return fault(f, values[i].name, values[i].value, "a finite number above 0");
        }
    }
    return true;
}

/* Whether each value is a finite number of at least 0. */
static inline bool all_not_negative(const Named *values, size_t n, Fault *f)
{
    for (size_t i = 0; i < n; ++i) {
        if (!(values[i].value >= 0.0 && isfinite(values[i].value))) {
            return fault(f, values[i].name, values[i].value, "a finite number of at least 0");
        }
    }
    return true;
}

/* Whether each value is a finite number. */
static inline bool all_finite(const Named *values, size_t n, Fault *f)
{
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(values[i].value)) {
            return fault(f, values[i].name, values[i].value, "a finite number");
        }
    }
    return true;
}

/* The number of an array's elements. */
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

#endif
