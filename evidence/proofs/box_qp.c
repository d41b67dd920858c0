/* The planner's programme of a stage, of any numbers. */
#include "plan/box_qp.h"

#include "__fc_builtin.h"

extern volatile double any_real;
extern volatile int any_integer;
volatile double seen_real;
volatile int seen_integer;

int main(void)
{
    double H[CONTROLS][CONTROLS], g[CONTROLS], low[CONTROLS], high[CONTROLS], u[CONTROLS], y[CONTROLS * ERRORS];
    bool free[CONTROLS];
    for (int i = 0; i < CONTROLS; ++i) {
        for (int j = 0; j < CONTROLS; ++j) {
            H[i][j] = any_real;
        }
        g[i] = any_real;
        low[i] = any_real;
        high[i] = any_real;
        u[i] = any_real;
    }
    for (int i = 0; i < CONTROLS * ERRORS; ++i) {
        y[i] = any_real;
    }
    const BoxQp qp = {(const double (*)[CONTROLS])H, g, low, high};
    for (int passes = 0; passes <= 2 * QP_PASSES; ++passes) {
        seen_integer = controller_planned_box_qp(&qp, passes, u, free);
    }
    controller_planned_solve_free(qp.H, free, ERRORS, y);
    for (int i = 0; i < CONTROLS; ++i) {
        seen_real = u[i];
        seen_integer = free[i];
    }
    for (int i = 0; i < CONTROLS * ERRORS; ++i) {
        seen_real = y[i];
    }
    return 0;
}
