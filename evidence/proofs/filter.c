/* A measurement taken by the estimator's filters, of any numbers: each number of states that its contract allows. */
#include "filter.h"

#include "__fc_builtin.h"

extern volatile double any_real;
extern volatile int any_integer;

static void fill(int n, double x[])
{
    for (int i = 0; i < n; ++i) {
        x[i] = any_real;
    }
}

int main(void)
{
    double y[3], r[3], H[9], P[144];
    fill(3, y);
    fill(3, r);
    fill(9, H);
    const Innovation innovation = {
        vector(y), {vector(H), vector(H + 3), vector(H + 6)}, any_integer != 0, vector(r), 0.0};
    for (int n = 1; n <= 12; ++n) {
        LongCorrection by;
        fill(144, P);
        (void)estimator_correct_states(&innovation, n, P + 144 - n * n, &by);
    }
    return 0;
}
