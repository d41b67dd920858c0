/* docs/how/planned-plan.md, Iterative LQR. Tests: test_box_qp.py. */
#include "box_qp.h"

#include <string.h>

#include "vector.h"

static const double GAIN_MIN = 1e-12;   /* of the value: a step that gains less is the last */
static const double STEP_MIN = 1e-22;   /* the same of what Newton's step would gain */
static const double PIVOT_MIN = 1e-300; /* keeps a pivot of zero from dividing */

static double inside(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* L D L' of the rows and columns of H that are free, of the unit matrix in the others; `pivot` is D^-1. */
typedef struct {
    double L[CONTROLS][CONTROLS], pivot[CONTROLS];
} Factors;

static void factorise(const double (*H)[CONTROLS], const bool free[CONTROLS], Factors *f)
{
    for (int i = 0; i < CONTROLS; ++i) {
        double d = free[i] ? H[i][i] : 1.0;
        for (int j = 0; j < i; ++j) {
            double sum = free[i] && free[j] ? H[i][j] : 0.0;
            for (int k = 0; k < j; ++k) {
                sum -= f->L[i][k] * f->L[k][j];
            }
            f->L[i][j] = sum * f->pivot[j];
            f->L[j][i] = sum; /* above the diagonal D L' */
            d -= sum * f->L[i][j];
        }
        f->pivot[i] = 1.0 / larger(d, PIVOT_MIN);
    }
}

static void solve_column(const Factors *f, const bool free[CONTROLS], int stride, double *y)
{
    double *const y1 = y + stride, *const y2 = y1 + stride, *const y3 = y2 + stride;
    const double a = free[0] ? *y : 0.0;
    const double b = (free[1] ? *y1 : 0.0) - f->L[1][0] * a;
    const double c = (free[2] ? *y2 : 0.0) - f->L[2][0] * a - f->L[2][1] * b;
    const double d = (free[3] ? *y3 : 0.0) - f->L[3][0] * a - f->L[3][1] * b - f->L[3][2] * c;
    *y3 = d * f->pivot[3];
    *y2 = c * f->pivot[2] - f->L[3][2] * *y3;
    *y1 = b * f->pivot[1] - f->L[2][1] * *y2 - f->L[3][1] * *y3;
    *y = a * f->pivot[0] - f->L[1][0] * *y1 - f->L[2][0] * *y2 - f->L[3][0] * *y3;
}

void controller_planned_solve_free(const double (*H)[CONTROLS], const bool free[CONTROLS], int columns, double *y)
{
    Factors f;
    factorise(H, free, &f);
    for (int c = 0; c < columns; ++c) {
        solve_column(&f, free, columns, y + c);
    }
}

/* The slope H u + g; returns the value. */
static double slope_at(const BoxQp *qp, const double u[CONTROLS], double slope[CONTROLS])
{
    const double a = u[0], b = u[1], c = u[2], d = u[3];
    double twice = 0.0;
    for (int i = 0; i < CONTROLS; ++i) {
        const double row = qp->H[i][0] * a + qp->H[i][1] * b + qp->H[i][2] * c + qp->H[i][3] * d;
        slope[i] = row + qp->g[i];
        twice += u[i] * (slope[i] + qp->g[i]);
    }
    return 0.5 * twice;
}

/* Half of Newton's step until the value falls: the last trial, its slope and its value. */
static double search_along(const BoxQp *qp, const double u[CONTROLS], const double step[CONTROLS], double best,
                           double trial[CONTROLS], double slope[CONTROLS], int *work)
{
    double share = 1.0, now = best;
    for (int k = 0; k < TRIALS && (k == 0 || !(now < best)); ++k, share *= 0.5) {
        for (int i = 0; i < CONTROLS; ++i) {
            trial[i] = inside(u[i] + share * step[i], qp->low[i], qp->high[i]);
        }
        now = slope_at(qp, trial, slope);
        *work += k > 0 ? WORK_TRIAL : 0;
    }
    return now;
}

/* Each variable's own minimum, one after the other, which always descends. */
static double descend_one_by_one(const BoxQp *qp, const double u[CONTROLS], double trial[CONTROLS],
                                 double slope[CONTROLS])
{
    memcpy(trial, u, CONTROLS * sizeof trial[0]);
    for (int i = 0; i < CONTROLS; ++i) {
        double sum = qp->g[i];
        for (int j = 0; j < CONTROLS; ++j) {
            sum += qp->H[i][j] * trial[j];
        }
        trial[i] = inside(trial[i] - sum / qp->H[i][i], qp->low[i], qp->high[i]);
    }
    return slope_at(qp, trial, slope);
}

int controller_planned_box_qp(const BoxQp *qp, int passes, double u[CONTROLS], bool free[CONTROLS])
{
    double slope[CONTROLS];
    int work = 0;
    for (int i = 0; i < CONTROLS; ++i) {
        u[i] = inside(u[i], qp->low[i], qp->high[i]);
    }
    double best = slope_at(qp, u, slope);
    //@ loop unroll 13;
    for (int pass = 0;; ++pass) {
        double step[CONTROLS], trial[CONTROLS], there[CONTROLS], expected = 0.0;
        for (int i = 0; i < CONTROLS; ++i) {
            free[i] = !((u[i] <= qp->low[i] && slope[i] > 0.0) || (u[i] >= qp->high[i] && slope[i] < 0.0));
            step[i] = -slope[i];
        }
        if (pass == passes) {
            return work;
        }
        work += WORK_PASS;
        controller_planned_solve_free(qp->H, free, 1, step);
        for (int i = 0; i < CONTROLS; ++i) {
            expected -= slope[i] * step[i];
        }
        if (!(expected > STEP_MIN * fabs(best))) {
            return work;
        }
        double now = search_along(qp, u, step, best, trial, there, &work);
        if (!(now < best)) { /* the bounds bend Newton's step too far */
            work += WORK_ONE_BY_ONE;
            now = descend_one_by_one(qp, u, trial, there);
            if (!(now < best)) {
                return work;
            }
        }
        const bool done = best - now < GAIN_MIN * (fabs(best) + fabs(now));
        best = now;
        memcpy(u, trial, sizeof trial);
        memcpy(slope, there, sizeof slope);
        if (done) {
            passes = pass + 1; /* once more, for `free` */
        }
    }
}
