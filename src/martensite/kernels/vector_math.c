/* Declarations after which a loop over lanes calls functions of vectors, where glibc has them. */

#include <math.h>
#include <string.h>

#if defined(__GLIBC__) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#pragma omp declare simd notinbranch
double exp(double);
#pragma omp declare simd notinbranch
double log(double);
#pragma omp declare simd notinbranch
double pow(double, double);
#pragma omp declare simd notinbranch
double sin(double);
#pragma omp declare simd notinbranch
double cos(double);
#if __GLIBC_PREREQ(2, 35)
#pragma omp declare simd notinbranch
double tanh(double);
#endif
#endif
