/* The part of <math.h> that the blocks use, for FMUs that are linked with no C library: instructions of the processor,
 * and the functions of elementary.c. */
#ifndef FREESTANDING_MATH_H
#define FREESTANDING_MATH_H

/* The same bits from any compiler's defaults: no multiply-add in one rounding. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif

#define INFINITY __builtin_inf()
#define NAN __builtin_nan("")
#define isfinite(x) __builtin_isfinite(x)
#define isinf(x) __builtin_isinf(x)
#define isnan(x) __builtin_isnan(x)
#define signbit(x) __builtin_signbit(x)
#define fabs(x) __builtin_fabs(x)
#define sqrt(x) __builtin_sqrt(x)
#define copysign(x, y) __builtin_copysign(x, y)

/* Names of our own: a compiler replaces a function called sin by what it knows of it, and a host may have one. */
#define sin portable_sin
#define cos portable_cos
#define atan2 portable_atan2
#define log portable_log
#define log1p portable_log1p
#define exp portable_exp
#define expm1 portable_expm1

#if defined(__ELF__)
#pragma GCC visibility push(hidden)
#endif
#ifdef __cplusplus
extern "C" {
#endif
double sin(double x);
double cos(double x);
double atan2(double y, double x);
double log(double x);
double log1p(double x);
double exp(double x);
double expm1(double x);
#ifdef __cplusplus
}
#endif
#if defined(__ELF__)
#pragma GCC visibility pop
#endif

#endif
