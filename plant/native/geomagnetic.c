/* V_nm + i W_nm = (a/r)^(n+1) P_nm(sin phi) exp(i m lambda) by Cunningham's recursion in Cartesian components, nothing
 * singular at the poles, and B as its gradient: Montenbruck and Gill, Satellite Orbits, section 3.2.
 * Tests: tests/native/test_plant.py. */
#include "geomagnetic.h"

static const double RADIUS = 6371200.0; /* m, of every WMM and IGRF model */

Field plant_field_of(const FieldModel *model, double year, int degree)
{
    const int last = model->epochs - 1;
    int i = last;
    if (last > 0 && year < model->years[last]) {
        for (i = 0; i + 1 < last && model->years[i + 1] <= year;) {
            ++i;
        }
    }
    const double elapsed = year - model->years[i];
    const double share = i < last ? elapsed / (model->years[i + 1] - model->years[i]) : 0.0;
    Field field = {degree, {{0.0}}, {{0.0}}};
    int k = 0;
    for (int n = 1; n <= degree; ++n) {
        double ratio = 1.0; /* (n - m)!/(n + m)! */
        for (int m = 0; m <= n; ++m, ++k) {
            if (m > 0) {
                ratio /= (double)((n - m + 1) * (n + m));
            }
            const double scale = 1e-9 * sqrt((m == 0 ? 1.0 : 2.0) * ratio);
            double g = model->g[i][k], h = model->h[i][k];
            if (i < last) {
                g += share * (model->g[i + 1][k] - g);
                h += share * (model->h[i + 1][k] - h);
            } else {
                g += elapsed * model->g_rate[k];
                h += elapsed * model->h_rate[k];
            }
            field.g[n][m] = scale * g;
            field.h[n][m] = scale * h;
        }
    }
    return field;
}

Vector plant_field_at(const Field *field, Vector r)
{
    enum { SIZE = FIELD_DEGREE_MAX + 2 };
    double V[SIZE][SIZE], W[SIZE][SIZE];
    const int N = field->degree + 1;
    const double r2 = dot(r, r);
    const Vector s = scale(RADIUS / r2, r);
    const double rho2 = RADIUS * RADIUS / r2;
    V[0][0] = sqrt(rho2);
    W[0][0] = 0.0;
    for (int m = 0; m <= N; ++m) {
        if (m > 0) {
            V[m][m] = (2 * m - 1) * (s.x * V[m - 1][m - 1] - s.y * W[m - 1][m - 1]);
            W[m][m] = (2 * m - 1) * (s.x * W[m - 1][m - 1] + s.y * V[m - 1][m - 1]);
        }
        if (m < N) {
            V[m + 1][m] = (2 * m + 1) * s.z * V[m][m];
            W[m + 1][m] = (2 * m + 1) * s.z * W[m][m];
        }
        for (int n = m + 2; n <= N; ++n) {
            const double a = (2 * n - 1) * s.z / (n - m), b = (n + m - 1) * rho2 / (n - m);
            V[n][m] = a * V[n - 1][m] - b * V[n - 2][m];
            W[n][m] = a * W[n - 1][m] - b * W[n - 2][m];
        }
    }
    Vector B = {0.0, 0.0, 0.0};
    for (int n = 1; n < N; ++n) {
        B.x += field->g[n][0] * V[n + 1][1];
        B.y += field->g[n][0] * W[n + 1][1];
        B.z += (n + 1) * field->g[n][0] * V[n + 1][0];
        for (int m = 1; m <= n; ++m) {
            const double g = field->g[n][m], h = field->h[n][m];
            const double lower = (double)((n - m + 2) * (n - m + 1));
            B.x +=
                0.5 * (g * V[n + 1][m + 1] + h * W[n + 1][m + 1] - lower * (g * V[n + 1][m - 1] + h * W[n + 1][m - 1]));
            B.y +=
                0.5 * (g * W[n + 1][m + 1] - h * V[n + 1][m + 1] + lower * (g * W[n + 1][m - 1] - h * V[n + 1][m - 1]));
            B.z += (n - m + 1) * (g * V[n + 1][m] + h * W[n + 1][m]);
        }
    }
    return B;
}
