/* A number with its derivative in one direction. The block's C is compiled a second time with Dual in the place of
 * double, as C++: values keep their bits, and derivatives are exact to rounding. At a limit or at the corner of a
 * magnitude the derivative is that of the side which the C takes; that of |x| at 0 is 0.
 * Tests: tests/native/test_derivatives.py. */
#ifndef DUAL_H
#define DUAL_H

#define restrict __restrict
#define _Static_assert static_assert

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#undef isfinite
#undef isinf
#undef fabs
#undef sqrt
#undef copysign

struct Dual {
    double v, d;
    Dual() = default;
    constexpr Dual(double value, double slope = 0.0) : v(value), d(slope)
    {
    }
    constexpr explicit operator int() const
    {
        return (int)v;
    }

    friend constexpr Dual operator+(Dual a, Dual b)
    {
        return {a.v + b.v, a.d + b.d};
    }
    friend constexpr Dual operator-(Dual a, Dual b)
    {
        return {a.v - b.v, a.d - b.d};
    }
    friend constexpr Dual operator-(Dual a)
    {
        return {-a.v, -a.d};
    }
    friend constexpr Dual operator*(Dual a, Dual b)
    {
        return {a.v * b.v, a.v * b.d + a.d * b.v};
    }
    friend constexpr Dual operator/(Dual a, Dual b)
    {
        return {a.v / b.v, (a.d - a.v / b.v * b.d) / b.v};
    }
    friend constexpr bool operator<(Dual a, Dual b)
    {
        return a.v < b.v;
    }
    friend constexpr bool operator>(Dual a, Dual b)
    {
        return a.v > b.v;
    }
    friend constexpr bool operator<=(Dual a, Dual b)
    {
        return a.v <= b.v;
    }
    friend constexpr bool operator>=(Dual a, Dual b)
    {
        return a.v >= b.v;
    }
    friend constexpr bool operator==(Dual a, Dual b)
    {
        return !(a.v < b.v) && !(a.v > b.v) && a.v - a.v == b.v - b.v;
    }
    friend constexpr bool operator!=(Dual a, Dual b)
    {
        return !(a == b);
    }
    Dual &operator+=(Dual b)
    {
        return *this = *this + b;
    }
    Dual &operator-=(Dual b)
    {
        return *this = *this - b;
    }
    Dual &operator*=(Dual b)
    {
        return *this = *this * b;
    }
    Dual &operator/=(Dual b)
    {
        return *this = *this / b;
    }
};

/* f(a) with f'(a) = slope; a constant stays one where the slope is infinite. */
static inline Dual chained(Dual a, double value, double slope)
{
    return {value, a.d < 0.0 || a.d > 0.0 ? slope * a.d : 0.0};
}

static inline bool isfinite(Dual a)
{
    return __builtin_isfinite(a.v);
}

static inline bool isinf(Dual a)
{
    return __builtin_isinf(a.v);
}

static inline Dual fabs(Dual a)
{
    return chained(a, __builtin_fabs(a.v), a.v > 0.0 ? 1.0 : a.v < 0.0 ? -1.0 : 0.0);
}

static inline Dual copysign(Dual a, Dual b)
{
    const double value = __builtin_copysign(a.v, b.v);
    return chained(a, value, value * a.v < 0.0 ? -1.0 : 1.0);
}

static inline Dual sqrt(Dual a)
{
    const double root = __builtin_sqrt(a.v);
    return chained(a, root, 0.5 / root);
}

static inline Dual sin(Dual a)
{
    return chained(a, sin(a.v), cos(a.v));
}

static inline Dual cos(Dual a)
{
    return chained(a, cos(a.v), -sin(a.v));
}

static inline Dual log1p(Dual a)
{
    return chained(a, log1p(a.v), 1.0 / (1.0 + a.v));
}

static inline Dual atan2(Dual y, Dual x)
{
    const double square = x.v * x.v + y.v * y.v;
    return {atan2(y.v, x.v), (x.v * y.d - y.v * x.d) / square};
}

#endif
