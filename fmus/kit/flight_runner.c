/* Plays the reference vector through the block and compares its outputs with those of the FMU. No file is read, so it
 * runs on a board as it does on a desk. Exit status 0: the same bits; 1: beyond a tolerance; 2: within them, but other
 * bits, as with another library of elementary functions or another order of operations. */
#include "vectors.h"

#include <stdio.h>
#include <string.h>

/* FNV-1a of the bits of the numbers. */
static uint64_t with_bits(uint64_t hash, const double x[], int n)
{
    for (int i = 0; i < n; ++i) {
        uint64_t word;
        memcpy(&word, &x[i], sizeof word);
        for (int k = 0; k < 8; ++k) {
            hash = (hash ^ ((word >> (8 * k)) & 0xFFu)) * 1099511628211u;
        }
    }
    return hash;
}

static int refused(const Fault *f, int row)
{
    printf("row %d: %s: expected %s\n", row, f->name, f->expected);
    return 1;
}

int main(void)
{
    static Law law;
    static State state;
    Inputs u = start;
    Outputs y;
    Fault f = {"none", "", NULL, 0.0};
    uint64_t hash = 14695981039346656037u;
    double worst = 0.0;
    const char *where = "all";
    memset(&y, 0, sizeof y);
    set_inputs(&u, given[0]);
    if (!block_check(&parameters, &f)) {
        return refused(&f, 0);
    }
    block_prepare(&parameters, &law);
    if (!block_start(&law, &u, &state, &f) || !block_outputs(&law, &state, &u, &y, &f)) {
        return refused(&f, 0);
    }
    for (int row = 0; row < ROWS; ++row) {
        double x[OUTPUTS];
        if (row > 0) {
            set_inputs(&u, given[row - 1]); /* held over the step that ends at this row */
            if (!block_step(&law, &state, &u, STEP, &y, &f)) {
                return refused(&f, row);
            }
        }
        get_outputs(&y, x);
        hash = with_bits(hash, x, OUTPUTS);
        for (int i = 0; i < OUTPUTS; ++i) {
            const double difference = x[i] > expected[row][i] ? x[i] - expected[row][i] : expected[row][i] - x[i];
            if (!(difference / tolerance[i] <= worst)) {
                worst = difference / tolerance[i];
                where = names[i];
            }
        }
    }
    printf("%s: %d rows of %d outputs; the largest difference is %.2g of its tolerance (%s); bits %08lx%08lx, %s\n",
           BLOCK, ROWS, OUTPUTS, worst, where, (unsigned long)(hash >> 32), (unsigned long)(hash & 0xFFFFFFFFu),
           hash == bits ? "those of the FMU" : "not those of the FMU");
    return !(worst <= 1.0) ? 1 : hash == bits ? 0 : 2;
}
