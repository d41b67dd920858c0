/* sin, cos, atan2, log, log1p, exp and expm1, so that an FMU needs no library at all and gives the same bits on
 * Linux, Windows and macOS, whose own elementary functions differ in the last place. Each is within 2 units in the
 * last place (tests/native/test_elementary.py). Only the FMUs are linked with this file; a law that is lifted out
 * uses its own platform's <math.h>. */
#include <math.h>
#include <stdint.h>
#include <string.h>

static const double shift = 6755399441055744.0; /* 1.5 * 2^52: adding it and taking it away rounds to an integer */

/* Polynomials in Taylor's coefficients; the arguments are reduced until these suffice. n is even: even and odd powers
 * are summed apart, so that a processor works on both at once. */
static double horner(double x, const double c[], int n)
{
    const double z = x * x;
    double even = c[n - 2], odd = c[n - 1];
    for (int i = n - 4; i >= 0; i -= 2) {
        even = even * z + c[i];
        odd = odd * z + c[i + 1];
    }
    return even + odd * x;
}

static double sine(double x) /* |x| <= pi/4 */
{
    static const double c[] = {-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
                               -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
    const double z = x * x;
    return x + x * z * horner(z, c, 8);
}

static double cosine(double x) /* |x| <= pi/4 */
{
    static const double c[] = {
        1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,          -1.0 / 3628800.0,
        1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0, -1.0 / 6402373705728000.0};
    const double z = x * x, half = 0.5 * z;
    const double w = 1.0 - half;
    return w + ((1.0 - w - half) + z * z * horner(z, c, 8)); /* with what 1 - half lost */
}

/* x - n pi/2 with n the nearest integer, of which the last two bits are returned. pi/2 in three parts: good to a unit
 * in the last place of the result up to |x| of 1.6e6, and beyond to what the rounding of x leaves anyway. */
static unsigned reduce(double x, double *r)
{
    static const double part1 = 1.57079632673412561417e+00; /* 33 bits of pi/2 */
    static const double part2 = 6.07710050630396597660e-11; /* the next 33 */
    static const double part3 = 2.02226624879595063154e-21; /* the rest */
    if (!(x > -1e9 && x < 1e9)) {
        *r = x - x; /* NaN of NaN and infinity; angles so large have lost their meaning: 0 */
        return 0;
    }
    //@ assert angle: \is_finite(x);
    const double n = (x * 0.63661977236758134308 + shift) - shift;
    const double a = x - n * part1, w = n * part2;
    const double b = a - w;
    *r = b - (n * part3 - ((a - b) - w));
    return (unsigned)((int32_t)n & 3);
}

double sin(double x)
{
    double r;
    const unsigned quadrant = reduce(x, &r);
    const double y = (quadrant & 1u) != 0u ? cosine(r) : sine(r);
    return (quadrant & 2u) != 0u ? -y : y;
}

double cos(double x)
{
    double r;
    const unsigned quadrant = reduce(x, &r) + 1u;
    const double y = (quadrant & 1u) != 0u ? cosine(r) : sine(r);
    return (quadrant & 2u) != 0u ? -y : y;
}

/* atan(x) for 0 <= x <= 1: atan(k/8) + atan((x - k/8)/(1 + x k/8)), and a series below 1/16. */
static double arc(double x)
{
    static const double at[] = {0.0,
                                0.12435499454676143503,
                                0.24497866312686415417,
                                0.35877067027057222039,
                                0.46364760900080611621,
                                0.55859931534356243597,
                                0.64350110879328438680,
                                0.71882999962162450542,
                                0.78539816339744830962};
    static const double c[] = {-1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0};
    //@ assert quotient: \is_finite(x) && 0.0 <= x <= 1.0;
    const int k = (int)(8.0 * x + 0.5);
    const double y = 0.125 * k;
    const double t = (x - y) / (1.0 + x * y), z = t * t;
    return at[k] + (t + t * z * horner(z, c, 6));
}

double atan2(double y, double x)
{
    static const double pi = 3.14159265358979311600, pi_rest = 1.22464679914735317720e-16;
    const double p = fabs(x), q = fabs(y);
    double angle; /* of (|x|, |y|) */
    if (isnan(x) || isnan(y)) {
        return x + y;
    }
    if (p == q) { /* both zero or both infinite, too */
        angle = p > 0.0 ? 0.25 * pi : 0.0;
    } else if (q < p) {
        angle = arc(q / p);
    } else {
        angle = 0.5 * pi - (arc(p / q) - 0.5 * pi_rest);
    }
    if (signbit(x)) {
        angle = pi - (angle - pi_rest);
    }
    return signbit(y) ? -angle : angle;
}

/* 2^k, -1022 <= k <= 1023. */
static double power_of_two(int k)
{
    const uint64_t bits = (uint64_t)(1023 + k) << 52;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* k with x/2^k in [1, 2), of a normal x > 0; 1024 of infinity. */
static int exponent(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    const int k = (int)(bits >> 52) - 1023;
    //@ assert exponent: -1022 <= k <= 1024;
    return k;
}

static const double ln2_high = 6.93147180369123816490e-01, ln2_low = 1.90821492927058770002e-10;

/* ln(1 + x): 1 + x = 2^k (1 + f) with f in [-0.3, 0.42], and ln(1 + f) = f - f^2/2 + s (f^2/2 + R), s = f/(2 + f),
 * R = 2/3 s^2 + 2/5 s^4 + ... */
#ifdef PROOF_WITHIN_LIMITS
/*@ assigns \result \from x;
    ensures x >= 0.0 && x <= 0x1p1000 ==> \is_finite(\result) && 0.0 <= \result <= 710.0; */
#endif
double log1p(double x)
{
    static const double c[] = {2.0 / 3.0,  2.0 / 5.0,  2.0 / 7.0,  2.0 / 9.0,  2.0 / 11.0,
                               2.0 / 13.0, 2.0 / 15.0, 2.0 / 17.0, 2.0 / 19.0, 2.0 / 21.0};
    if (!(x > -1.0)) {
        return x == -1.0 ? -INFINITY : NAN;
    }
    if (isinf(x)) {
        return x;
    }
    int k = 0;
    double f = x, lost = 0.0;
    if (x < -0.29289 || x > 0.41421) {
        const double one_plus = 1.0 + x;
        lost = (x > 1.0 ? 1.0 - (one_plus - x) : x - (one_plus - 1.0)) / one_plus;
        k = exponent(one_plus * 0.70710678118654752440) + 1;
        f = (k > 0 ? 0.25 * one_plus * power_of_two(2 - k) : one_plus / 2.0 * power_of_two(1 - k)) - 1.0;
    }
    const double s = f / (2.0 + f), z = s * s, half_square = 0.5 * f * f;
    const double series = s * (half_square + z * horner(z, c, 10));
    return k * ln2_high + (f - (half_square - (series + (lost + k * ln2_low))));
}

/* ln(x) of a normal x; the smallest numbers of all, below 2^-1022, count as zero. */
double log(double x)
{
    static const double c[] = {2.0 / 3.0,  2.0 / 5.0,  2.0 / 7.0,  2.0 / 9.0,  2.0 / 11.0,
                               2.0 / 13.0, 2.0 / 15.0, 2.0 / 17.0, 2.0 / 19.0, 2.0 / 21.0};
    if (!(x >= 2.2250738585072014e-308)) {
        return x >= 0.0 ? -INFINITY : NAN;
    }
    if (isinf(x)) {
        return x;
    }
    const int k = exponent(x * 0.70710678118654752440 * 2.0);
    const double f = (k > 0 ? 0.25 * x * power_of_two(2 - k) : x / 2.0 * power_of_two(1 - k)) - 1.0;
    const double s = f / (2.0 + f), z = s * s, half_square = 0.5 * f * f;
    const double series = s * (half_square + z * horner(z, c, 10));
    return k * ln2_high + (f - (half_square - (series + k * ln2_low)));
}

/* x = k ln 2 + r, |r| <= 0.35; returns exp(r) - 1 and k. */
static double reduced_expm1(double x, int *k)
{
    static const double c[] = {1.0 / 6.0,        1.0 / 24.0,        1.0 / 120.0,        1.0 / 720.0,
                               1.0 / 5040.0,     1.0 / 40320.0,     1.0 / 362880.0,     1.0 / 3628800.0,
                               1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0, 1.0 / 87178291200.0};
    //@ assert exponent: \is_finite(x);
    const double n = (x * 1.44269504088896338700 + shift) - shift;
    const double high = x - n * ln2_high, low = n * ln2_low;
    const double r = high - low, lost = (high - r) - low;
    *k = (int)n;
    return r + (0.5 * r * r + (r * r * r * horner(r, c, 12) + lost * (1.0 + r)));
}

/* Results below 2^-1022 count as zero. */
double exp(double x)
{
    int k;
    if (isnan(x)) {
        return x;
    }
    if (x > 709.782712893384 || x < -708.39) {
        return x > 0.0 ? INFINITY : 0.0;
    }
    const double e = reduced_expm1(x, &k);
    return k > 0 ? 2.0 * (power_of_two(k - 1) * (1.0 + e)) : power_of_two(k) * (1.0 + e);
}

double expm1(double x)
{
    int k;
    if (isnan(x)) {
        return x;
    }
    if (x > 709.782712893384 || x < -40.0) {
        return x > 0.0 ? INFINITY : -1.0;
    }
    const double e = reduced_expm1(x, &k);
    const double half = power_of_two(k - 1);
    return k == 0 ? e : 2.0 * (half * e + (half - 0.5));
}
