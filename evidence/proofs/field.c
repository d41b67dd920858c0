/* The onboard field and a two-body orbit, of any numbers; a model of the field has one to three epochs here. */
#include "onboard_field.h"
#include "two_body.h"

#include "__fc_builtin.h"

volatile double any_real, seen_real;

int main(void)
{
    double years[3], g[3][ONBOARD_TERMS], h[3][ONBOARD_TERMS], g_rate[ONBOARD_TERMS], h_rate[ONBOARD_TERMS];
    const double error[3] = {any_real, any_real, any_real};
    const Vector place = {any_real, any_real, any_real};
    OnboardField field;
    TwoBody orbit;
    Vector r, v;
    Frama_C_make_unknown((char *)years, sizeof years);
    Frama_C_make_unknown((char *)g, sizeof g);
    Frama_C_make_unknown((char *)h, sizeof h);
    Frama_C_make_unknown((char *)g_rate, sizeof g_rate);
    Frama_C_make_unknown((char *)h_rate, sizeof h_rate);
    Frama_C_make_unknown((char *)&orbit, sizeof orbit);
    const GaussModel model = {Frama_C_interval(1, 3), years, "", any_real, g, h, g_rate, h_rate};
    onboard_field(&model, Frama_C_double_interval(-1e7, 1e7), Frama_C_interval(1, ONBOARD_DEGREE_MAX), error, &field);
    seen_real = largest(onboard_field_at(&field, any_real, place));
    two_body_at(&orbit, any_real, &r, &v);
    seen_real = largest(r) + largest(v);
    return 0;
}
