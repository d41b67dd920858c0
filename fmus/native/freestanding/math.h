/* The part of <math.h> that the blocks use, for FMUs that are linked with no C library: instructions of the processor,
 * and the functions of elementary.c. */
#ifndef FREESTANDING_MATH_H
#define FREESTANDING_MATH_H

#define INFINITY __builtin_inf()
#define NAN __builtin_nan("")
#define isfinite(x) __builtin_isfinite(x)
#define isinf(x) __builtin_isinf(x)
#define isnan(x) __builtin_isnan(x)
#define signbit(x) __builtin_signbit(x)
#define fabs(x) __builtin_fabs(x)
#define sqrt(x) __builtin_sqrt(x)
#define copysign(x, y) __builtin_copysign(x, y)

double sin(double x);
double cos(double x);
double atan2(double y, double x);
double log(double x);
double log1p(double x);
double exp(double x);
double expm1(double x);

#endif
