/* What the two sides of a block in single precision share: the shell or the
 * link with doubles, the block with floats. */
#ifndef CONVERSION_H
#define CONVERSION_H

#include <stdbool.h>
#include <stddef.h>

enum { FIELD_REAL, FIELD_OTHER };

/* A variable in a structure: place, elements that are numbers, or bytes. */
typedef struct {
    size_t offset, count;
    int kind;
} Field;

typedef struct {
    const char *name, *expected, *text;
    double value;
} Refusal;

extern const Field wide_parameters[], wide_inputs[], wide_outputs[]; /* of the structures with doubles */

bool single_check(const void *p, Refusal *f);
void single_prepare(const void *p, void *law);
/* x begins with the time, a double, and the block's own state follows. A law may have work space in it, which a call writes. */
bool single_start(void *law, const void *u, void *x, Refusal *f);
bool single_outputs(void *law, const void *x, const void *u, void *y, Refusal *f);
bool single_step(void *law, void *x, const void *u, double h, void *y, Refusal *f);

#endif
