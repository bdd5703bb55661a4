/* Numbers as pairs of vectors, and the operations on them. */

#if defined(__AVX512F__)
#define WIDTH 8
#define FILL(x) {x, x, x, x, x, x, x, x}
#elif defined(__AVX__)
#define WIDTH 4
#define FILL(x) {x, x, x, x}
#else
#define WIDTH 2
#define FILL(x) {x, x}
#endif
#define PAIR (2 * WIDTH)
#ifdef __OPTIMIZE__
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif
typedef double vector __attribute__((vector_size(8 * WIDTH)));
typedef double loose __attribute__((vector_size(8 * WIDTH), aligned(8), may_alias));
typedef long long mask __attribute__((vector_size(8 * WIDTH)));
typedef struct { vector a, b; } number;
typedef struct { mask a, b; } flags;
#define FLAGS(x) ((flags){FILL(x), FILL(x)})
#define AT(array, row) load((array) + (row) * n + l)
#define PUT(array, row, value) save((array) + (row) * n + l, value)
#define UNARY(name, expression) \
INLINE vector name##_1(vector x) { return expression; } \
INLINE number name(number x) { return (number){name##_1(x.a), name##_1(x.b)}; }
#define BINARY(name, expression) \
INLINE vector name##_1(vector x, vector y) { return expression; } \
INLINE number name(number x, number y) { \
    return (number){name##_1(x.a, y.a), name##_1(x.b, y.b)}; \
}
#define TEST(name, operator) \
INLINE flags name(number x, number y) { \
    return (flags){x.a operator y.a, x.b operator y.b}; \
}
#define LOGIC(name, operator) \
INLINE flags name(flags x, flags y) { \
    return (flags){x.a operator y.a, x.b operator y.b}; \
}
#define BY_LANE(name, function) \
INLINE number name(number x) { \
    double lanes[PAIR]; \
    save(lanes, x); \
    _Pragma("omp simd") \
    for (int i = 0; i < PAIR; i++) lanes[i] = function(lanes[i]); \
    return load(lanes); \
}
INLINE number all(double x) { return (number){FILL(x), FILL(x)}; }
INLINE number load(const double *p) {
    return (number){*(const loose *)p, *(const loose *)(p + WIDTH)};
}
INLINE void save(double *p, number x) {
    *(loose *)p = x.a;
    *(loose *)(p + WIDTH) = x.b;
}
INLINE vector pick_1(mask m, vector x, vector y) {
    return (vector)((m & (mask)x) | (~m & (mask)y));
}
INLINE number pick(flags m, number x, number y) {
    return (number){pick_1(m.a, x.a, y.a), pick_1(m.b, x.b, y.b)};
}
INLINE flags not_of(flags x) { return (flags){~x.a, ~x.b}; }
BINARY(plus, x + y)
BINARY(minus, x - y)
BINARY(times, x * y)
BINARY(over, x / y)
BINARY(least, pick_1(x < y, x, y))
BINARY(most, pick_1(x > y, x, y))
UNARY(minus_of, -x)
UNARY(size_of, (vector)((mask)x & 0x7fffffffffffffffLL))
TEST(below, <)
TEST(at_most, <=)
TEST(above, >)
TEST(at_least, >=)
TEST(differs, !=)
LOGIC(both, &)
LOGIC(either, |)
INLINE int some(flags x) {
    const mask either = x.a | x.b;
    long long found = 0;
    for (int i = 0; i < WIDTH; i++) found |= either[i];
    return found != 0;
}
BY_LANE(sqrt_of, sqrt)
BY_LANE(exp_1, exp)
BY_LANE(log_1, log)
BY_LANE(sin_of, sin)
BY_LANE(cos_of, cos)
BY_LANE(tanh_of, tanh)
BY_LANE(rint_of, rint)
INLINE number root_of(number x) {
    return pick(above(x, all(0.0)), sqrt_of(most(x, all(0.0))), all(0.0));
}
/* functions of vectors take long over results that are no normal numbers */
INLINE number exp_of(number x) {
    const number y = exp_1(most(least(x, all(700.0)), all(-700.0)));
    return pick(above(x, all(-700.0)), y, all(0.0));
}
INLINE number log_of(number x) { return log_1(most(x, all(1e-300))); }
INLINE number pow_1(number x, number y) {
    double bases[PAIR], exponents[PAIR];
    save(bases, x);
    save(exponents, y);
    _Pragma("omp simd")
    for (int i = 0; i < PAIR; i++) bases[i] = pow(bases[i], exponents[i]);
    return load(bases);
}
