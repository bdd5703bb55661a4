/* What the kernels ask of libm. `exp`, `log`, `sin`, `cos` and `fmin` are those of the compiler's own
   runtime; roots, absolute values and rounding are instructions of WebAssembly. */
#ifndef MATH_H
#define MATH_H

#define HUGE_VAL __builtin_huge_val()

double exp(double), log(double), sin(double), cos(double), fmin(double, double), sqrt(double), fabs(double);

#define rint(x) __builtin_elementwise_roundeven(x)
#define ceil(x) __builtin_ceil(x)
#define isfinite(x) __builtin_isfinite(x)
#define isnan(x) __builtin_isnan(x)

/* Of positive bases. The error is that of the logarithm times the exponent: below 2e-13 up to 1e304. */
static inline double pow(double base, double exponent)
{
    return exp(exponent * log(base));
}

/* By Lambert's continued fraction up to 1, beyond by an exponential. */
static inline double tanh(double x)
{
    double tail = 23.0;
    if (fabs(x) > 1.0) return x > 0.0 ? 1.0 - 2.0 / (exp(2.0 * x) + 1.0) : 2.0 / (exp(-2.0 * x) + 1.0) - 1.0;
    for (int k = 21; k > 0; k -= 2) tail = k + x * x / tail;
    return x / tail;
}

/* For x >= 0, by the Chebyshev series of (1 + 2x) exp(x^2) erfc(x). */
static inline double erfc(double x)
{
    static const double series[] = {ERFCX_SERIES};
    const double z = (x - ERFCX_CENTRE) / (x + ERFCX_CENTRE);
    double sum = 0.0;
    for (int k = sizeof series / sizeof *series - 1; k >= 0; k--) sum = sum * z + series[k];
    return exp(-x * x) * sum / (1.0 + 2.0 * x);
}

#endif
