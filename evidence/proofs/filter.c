/* A measurement taken by the estimator's filters, of any numbers: nine states, and twelve of the bank. */
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
    double y[3], r[3], H[9], P9[81], P12[144];
    LongCorrection by_nine, by_twelve;
    fill(3, y);
    fill(3, r);
    fill(9, H);
    fill(81, P9);
    fill(144, P12);
    const Innovation innovation = {
        vector(y), {vector(H), vector(H + 3), vector(H + 6)}, any_integer != 0, vector(r), 0.0};
    (void)estimator_correct_states(&innovation, 9, P9, &by_nine);
    (void)estimator_correct_states(&innovation, 12, P12, &by_twelve);
    return 0;
}
