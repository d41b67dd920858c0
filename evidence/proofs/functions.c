/* Each elementary function of any number. */
extern volatile double any_real;
volatile double seen_real;

double sin(double x);
double cos(double x);
double atan2(double y, double x);
double log(double x);
double log1p(double x);
double exp(double x);
double expm1(double x);

int main(void)
{
    seen_real = sin(any_real);
    seen_real = cos(any_real);
    seen_real = atan2(any_real, any_real);
    seen_real = log(any_real);
    seen_real = log1p(any_real);
    seen_real = exp(any_real);
    seen_real = expm1(any_real);
    return 0;
}
