/* A drive as C knows it: the twin of martensite/signals/reader.py and moments.py. Before this text
   stands TONES, the most that any drive has. */

#include <math.h>

#define FEW 3
#define RESOLVED 0.5
#define SERIES 0.25

/* a drive as far as it is known: parabolas from start to start, and tones at all times */
typedef struct {
    long count, tones;
    const double *start, *level, *slope, *bend;
    const double *amplitude, *rate, *phase;
    double fastest;
    long whole; /* nothing comes after what is known */
} drive;

typedef struct {
    double mean, square, low, high, lapse, slope, square_slope;
} moments;

/* the tones of a drive at a time: cosine and sine of each */
typedef struct {
    double cosine[TONES + 1], sine[TONES + 1];
} tone_angles;

static double sinc(double x) {
    if (fabs(x) < SERIES) {
        const double z = x * x;
        return 1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0) *
               (1.0 - z * (1.0 / 42.0) * (1.0 - z * (1.0 / 72.0))));
    }
    return sin(x) / x;
}

/* (sin x / x - cos x) / x */
static double leaning(double x) {
    if (fabs(x) < SERIES) {
        const double z = x * x;
        return x * (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0))));
    }
    return (sin(x) / x - cos(x)) / x;
}

static long segment_at(const drive *d, double time, long near) {
    while (near + 1 < d->count && d->start[near + 1] <= time) near++;
    while (near > 0 && d->start[near] > time) near--;
    return near;
}

/* a drive without its tones, at a time or just `before` it */
static double level_at(const drive *d, double time, long near, int before) {
    long k = segment_at(d, time, near);
    if (before && k > 0 && !(d->start[k] < time)) k--;
    const double along = time - d->start[k];
    return d->level[k] + (d->slope[k] + d->bend[k] * along) * along;
}

static double value_at(const drive *d, double time, long near, int before) {
    double sum = level_at(d, time, near, before);
    for (long j = 0; j < d->tones; j++)
        sum += d->amplitude[j] * cos(d->rate[j] * time + d->phase[j]);
    return sum;
}

static tone_angles angles_at(const drive *d, double time) {
    tone_angles found;
    for (long j = 0; j < d->tones; j++) {
        const double angle = d->rate[j] * time + d->phase[j];
        found.cosine[j] = cos(angle);
        found.sine[j] = sin(angle);
    }
    return found;
}

/* `at` are the angles in the middle */
static moments moments_of(const drive *d, double begin, double end, long near, const tone_angles *at) {
    const double length = end - begin, middle = 0.5 * (begin + end), per = 1.0 / length;
    long k = segment_at(d, begin, near), pieces = 0;
    const long first = k;
    moments m = {0.0, 0.0, HUGE_VAL, -HUGE_VAL, 0.0, 0.0, 0.0};
    if (!d->tones && (k + 1 == d->count || d->start[k + 1] >= end) && d->slope[k] == 0.0 &&
        d->bend[k] == 0.0) {
        m.mean = m.low = m.high = d->level[k];
        m.square = m.mean * m.mean;
        return m;
    }
    double cross = 0.0, lean = 0.0, square_lean = 0.0, left = begin;
    const double *sin_a = at->sine, *cos_a = at->cosine;
    double reach[TONES + 1], share_a[TONES + 1];
    for (long j = 0; j < d->tones; j++) {
        reach[j] = 0.5 * d->rate[j] * length;
        share_a[j] = sinc(reach[j]);
    }
    for (;; k++, pieces++) {
        const double right = k + 1 < d->count && d->start[k + 1] < end ? d->start[k + 1] : end;
        const double half = 0.5 * (right - left), centre = left + half, aside = centre - middle;
        const double along = centre - d->start[k], d2 = d->bend[k];
        const double d0 = d->level[k] + (d->slope[k] + d2 * along) * along;
        const double d1 = d->slope[k] + 2.0 * d2 * along;
        const double share = 2.0 * half * per, third = half * half * (1.0 / 3.0);
        const double fifth = half * half * half * half * (1.0 / 5.0);
        const double mean = d0 + d2 * third;
        const double square = d0 * d0 + (d1 * d1 + 2.0 * d0 * d2) * third + d2 * d2 * fifth;
        const int alone = pieces == 0 && right == end;
        m.mean += share * mean;
        m.square += share * square;
        lean += share * (aside * mean + d1 * third);
        square_lean += share * (aside * square + 2.0 * d1 * (d0 * third + d2 * fifth));
        for (long j = 0; j < d->tones; j++) {
            const double x = d->rate[j] * half, angle = d->rate[j] * centre + d->phase[j];
            const double s0 = alone ? share_a[j] : sinc(x), c = alone ? cos_a[j] : cos(angle);
            if (d1 == 0.0 && d2 == 0.0) {
                cross += share * d->amplitude[j] * c * d0 * s0;
                continue;
            }
            const double s = alone ? sin_a[j] : sin(angle);
            const double s1 = half * leaning(x);
            double s2;
            if (x < SERIES) {
                const double z = x * x;
                s2 = half * half *
                     (1.0 / 3.0 - z / 10.0 * (1.0 - 5.0 * z / 84.0 * (1.0 - 7.0 * z / 270.0)));
            } else {
                const double less = s0 - cos(x);
                s2 = half * half * (s0 - 2.0 * less / (x * x));
            }
            cross += share * d->amplitude[j] * (c * (d0 * s0 + d2 * s2) - s * d1 * s1);
        }
        const double slant = fabs(d1) * half, curve = d2 * half * half;
        const double low = d0 - slant + (curve < 0.0 ? curve : 0.0);
        const double high = d0 + slant + (curve > 0.0 ? curve : 0.0);
        m.low = low < m.low ? low : m.low;
        m.high = high > m.high ? high : m.high;
        left = right;
        if (!(right < end)) break;
    }
    const double mean = m.mean, square = m.square, twelve = 12.0 * per * per;
    const double slope = twelve * lean, second = twelve * square_lean;
    double swing = 0.0;
    m.slope = slope;
    m.square_slope = second;
    m.square += 2.0 * cross;
    for (long j = 0; j < d->tones; j++) {
        const double a = d->amplitude[j], size = fabs(a), level = a * cos_a[j], x = reach[j];
        const double spread = size * fabs(sin_a[j]) * x + 0.5 * size * x * x;
        m.mean += level * share_a[j];
        m.slope -= twelve * 0.5 * length * a * sin_a[j] * leaning(x);
        m.low += level - spread > -size ? level - spread : -size;
        m.high += level + spread < size ? level + spread : size;
        swing += x > RESOLVED ? size / d->rate[j] : 0.0;
        for (long i = 0; i <= j; i++) {
            const double together = cos_a[i] * cos_a[j], crossed = sin_a[i] * sin_a[j];
            const double near_ = i == j ? 1.0 : sinc(x - reach[i]);
            const double part = (together + crossed) * near_ +
                                (together - crossed) * sinc(x + reach[i]);
            m.square += (i == j ? 0.5 : 1.0) * a * d->amplitude[i] * part;
        }
    }
    if (d->tones) m.square_slope += 2.0 * (m.mean * m.slope - mean * slope);
    const double size = fabs(m.low) > fabs(m.high) ? fabs(m.low) : fabs(m.high);
    if (!(size > 0.0)) return m;
    m.lapse = swing / size;
    if (pieces == 0) return m;
    /* how far the integrals of u and u2 are from those of straight lines */
    double sum = 0.0, squares = 0.0, far = 0.0, farther = 0.0;
    left = begin;
    for (k = first; left < end; k++) {
        const double right = k + 1 < d->count && d->start[k + 1] < end ? d->start[k + 1] : end;
        const double half = 0.5 * (right - left), along = left + half - d->start[k], d2 = d->bend[k];
        const double d0 = d->level[k] + (d->slope[k] + d2 * along) * along;
        const double d1 = d->slope[k] + 2.0 * d2 * along, third = half * half / 3.0;
        sum += 2.0 * half * (d0 + d2 * third);
        squares += 2.0 * half * (d0 * d0 + (d1 * d1 + 2.0 * d0 * d2) * third +
                                 d2 * d2 * half * half * half * half / 5.0);
        const double time = right - begin, bow = 0.5 * time * (time - length);
        const double a = fabs(sum - time * mean - slope * bow);
        const double b = fabs(squares - time * square - second * bow);
        far = a > far ? a : far;
        farther = b > farther ? b : farther;
        left = right;
    }
    far /= size;
    farther /= size * size;
    m.lapse += far > farther ? far : farther;
    return m;
}

/* the first edge in (begin, end), or end; how many there are, up to FEW + 1 */
static double first_edge(const drive *d, double begin, double end, long near, long *count) {
    long k = segment_at(d, begin, near) + 1, found = 0;
    const double edge = k < d->count && d->start[k] < end ? d->start[k] : end;
    for (; k < d->count && d->start[k] < end && found <= FEW; k++) found++;
    *count = found;
    return edge;
}
