#include "box_qp.h"

#include "vector.h"

static const double GAIN_MIN = 1e-12;   /* of the value: a step that gains less is the last */
static const double PIVOT_MIN = 1e-300; /* keeps a pivot of zero from dividing */
enum { HALVINGS = 8 };

static double inside(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

void controller_planned_solve_free(const double H[CONTROLS][CONTROLS], const bool free[CONTROLS], int columns, double *y)
{
    double L[CONTROLS][CONTROLS];
    int index[CONTROLS], n = 0;
    for (int i = 0; i < CONTROLS; ++i) {
        if (free[i]) {
            index[n++] = i;
        } else {
            for (int c = 0; c < columns; ++c) {
                y[i * columns + c] = 0.0;
            }
        }
    }
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j <= i; ++j) {
            double sum = H[index[i]][index[j]];
            for (int k = 0; k < j; ++k) {
                sum -= L[i][k] * L[j][k];
            }
            L[i][j] = i == j ? sqrt(larger(sum, PIVOT_MIN)) : sum / L[j][j];
        }
    }
    for (int c = 0; c < columns; ++c) {
        for (int i = 0; i < n; ++i) {
            double sum = y[index[i] * columns + c];
            for (int k = 0; k < i; ++k) {
                sum -= L[i][k] * y[index[k] * columns + c];
            }
            y[index[i] * columns + c] = sum / L[i][i];
        }
        for (int i = n - 1; i >= 0; --i) {
            double sum = y[index[i] * columns + c];
            for (int k = i + 1; k < n; ++k) {
                sum -= L[k][i] * y[index[k] * columns + c];
            }
            y[index[i] * columns + c] = sum / L[i][i];
        }
    }
}

static double value(const double H[CONTROLS][CONTROLS], const double g[CONTROLS], const double u[CONTROLS])
{
    double sum = 0.0;
    for (int i = 0; i < CONTROLS; ++i) {
        double row = 0.0;
        for (int j = 0; j < CONTROLS; ++j) {
            row += H[i][j] * u[j];
        }
        sum += u[i] * (0.5 * row + g[i]);
    }
    return sum;
}

/* Half of Newton's step until the value falls: the trial of the last, and its value. */
static double search_along(const double H[CONTROLS][CONTROLS], const double g[CONTROLS], const double low[CONTROLS],
                           const double high[CONTROLS], const double u[CONTROLS], const double step[CONTROLS], double best,
                           double trial[CONTROLS])
{
    double share = 1.0, now = best;
    for (int k = 0; k < HALVINGS && !(now < best); ++k, share *= 0.5) {
        for (int i = 0; i < CONTROLS; ++i) {
            trial[i] = inside(u[i] + share * step[i], low[i], high[i]);
        }
        now = value(H, g, trial);
    }
    return now;
}

/* Each variable's own minimum, one after the other, which always descends. */
static double descend_one_by_one(const double H[CONTROLS][CONTROLS], const double g[CONTROLS], const double low[CONTROLS],
                                 const double high[CONTROLS], const double u[CONTROLS], double trial[CONTROLS])
{
    for (int i = 0; i < CONTROLS; ++i) {
        trial[i] = u[i];
    }
    for (int i = 0; i < CONTROLS; ++i) {
        double sum = g[i];
        for (int j = 0; j < CONTROLS; ++j) {
            sum += H[i][j] * trial[j];
        }
        trial[i] = inside(trial[i] - sum / H[i][i], low[i], high[i]);
    }
    return value(H, g, trial);
}

void controller_planned_box_qp(const double H[CONTROLS][CONTROLS], const double g[CONTROLS], const double low[CONTROLS],
                               const double high[CONTROLS], int passes, double u[CONTROLS], bool free[CONTROLS])
{
    for (int i = 0; i < CONTROLS; ++i) {
        u[i] = inside(u[i], low[i], high[i]);
    }
    double best = value(H, g, u);
    for (int pass = 0;; ++pass) {
        double step[CONTROLS], slope[CONTROLS], trial[CONTROLS], expected = 0.0;
        for (int i = 0; i < CONTROLS; ++i) {
            slope[i] = g[i];
            for (int j = 0; j < CONTROLS; ++j) {
                slope[i] += H[i][j] * u[j];
            }
            free[i] = !((u[i] <= low[i] && slope[i] > 0.0) || (u[i] >= high[i] && slope[i] < 0.0));
            step[i] = -slope[i];
        }
        if (pass == passes) {
            return;
        }
        controller_planned_solve_free(H, free, 1, step);
        for (int i = 0; i < CONTROLS; ++i) {
            expected += slope[i] * step[i];
        }
        if (!(expected < 0.0)) {
            return;
        }
        double now = search_along(H, g, low, high, u, step, best, trial);
        if (!(now < best)) { /* the bounds bend Newton's step too far */
            now = descend_one_by_one(H, g, low, high, u, trial);
            if (!(now < best)) {
                return;
            }
        }
        const bool done = best - now < GAIN_MIN * (fabs(best) + fabs(now));
        best = now;
        for (int i = 0; i < CONTROLS; ++i) {
            u[i] = trial[i];
        }
        if (done) {
            passes = pass + 1; /* once more, for `free` */
        }
    }
}
