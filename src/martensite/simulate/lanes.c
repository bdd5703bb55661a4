/* The march of adaptive.c for runs side by side, LANES at a time, each on steps of its own: what one
   does changes no bit of another. A lane whose run has ended takes the next run. Drives are known as
   a whole, and no ledger is kept. What is done, and why, is said in martensite/simulate/adaptive.py.

   Before this text stand martensite/signals/reader.c, the kernels k_prepare, k_init, k_observe,
   k_judge, k_solve (or k_rosenbrock if the ORDER of a step is 4, else 2), k_ripple and k_points over
   LANES lanes, what marching.c and adaptive.c ask for, the numbers of adaptive.py, and which of the
   state are OBSERVED. Loops over lanes are written so that a compiler makes vectors of them: values
   are chosen, not branched upon, except where few lanes have something to do. */

#define LEAST_ERROR 1e-9
#define PART (ORDER == 4 ? 1.0 : 1.0 / 3.0)
#define POWER (ORDER == 4 ? 0.25 : 1.0 / 3.0) /* of an error, for the length of a step */
#define SEEN (JUDGED + ENVELOPE + HEATED)
#define SAID (11 + ACCOUNTS)
#define REPORTS 1
#define ANSWERS (ORDER == 4 ? 3 * SIZE : SIZE + REPORTS)
#define MOMENTS 7
#define IDLE 2 /* lanes without a run from which on runs are begun */
#define EACH(i) _Pragma("omp simd") for (long i = 0; i < LANES; i++)
#define EVERY(i) for (long i = 0; i < LANES; i++)
/* the lanes of a set of bits, one after another */
#define SOME(i, bits) for (long long left_ = (long long)(bits), i; left_ && (i = __builtin_ctzll(left_), 1); left_ &= left_ - 1)
#define BLEND(to, mask, from) EACH(i_) (to)[i_] = (mask)[i_] ? (from)[i_] : (to)[i_]

enum { OK = 0, LONG_STEP = 1, UNSOLVED = 2, NOT_FINITE = 4, OUT_OF_ENVELOPE = 7 };
enum { DONE = 0, PAUSED = 1, RECORD = 3 };
enum { MEAN, SQUARE, LOW, HIGH, LAPSE, SLOPE, SQUARE_SLOPE };

static const long widths[DRIVES + 1] = WIDTHS;
static const double floors[JUDGED + 1] = LEAST;
static const long places[HEATED + 1] = PLACES;
static const long parts[POINTS + 1] = PARTS;
static const double weights[POINTS + 1] = WEIGHTS;
static const long rates[RATES + 1] = PLACES_OF_RATES;
static const long start_of[POINTS + 1] = START;
static const long observed[SIZE + 1] = OBSERVED; /* whether outputs depend on a state */
static const long size_of_point[POINTS + 1] = SIZES;

typedef double column[LANES];
typedef long long flags_of_lanes[LANES]; /* as wide as numbers */

/* the segment of a drive in which steps begin, when the next one starts, and the tones, with their
   angles where steps begin */
typedef struct {
    flags_of_lanes run, cursor;
    column start, level, slope, bend, following;
    column amplitude[TONES + 1], speed[TONES + 1], phase[TONES + 1], cosine[TONES + 1], sine[TONES + 1];
} drives_of_lanes;

/* steps to samples that no polynomial reaches: they are made when there are enough to fill all lanes */
typedef struct {
    long count;
    flags_of_lanes run, sample, leaving;
    column begin, end, c[CONSTANTS], x[SIZE + INPUTS + 1], y[ANSWERS], row[OUTPUTS + 1];
    column owed[DRIVES + 1], line[SIZE + 1]; /* on a straight line between states that were solved */
    drives_of_lanes then[DRIVES + 1];
} steps_aside;

/* the runs under way: where they are, and the step that each tries */
typedef struct {
    long next_run, done;
    flags_of_lanes run, live, loaded, fresh, sample, status, place, at_edge, at_kink, known, split, leaps;
    column time, length, next, planned, grows, after_edge, after_kink, rough, last_half, power, lapse;
    column coming; /* time of the next sample */
    column steps, rejected, longest, ripple, residual, error, kink;
    column p[PARAMETERS + 1], c[CONSTANTS], state[SIZE + 1], owed[DRIVES + 1], seen[SEEN + 1];
    column rate[RATES + 1]; /* of the half step before the last */
    column low[JUDGED + 1], high[JUDGED + 1], scale[JUDGED + 1], range[JUDGED + 1];
    column limits[2 * ENVELOPE + 1];
    column points[NUMBERS + 1], earlier_points[NUMBERS + 1]; /* now, and half a step ago */
    /* start and middle of the last step, if there is no kink of a drive between them and now */
    column node_time[2], node_state[2][SIZE + 1], node_seen[2][JUDGED + 1];
    column older_time, older_seen[JUDGED + 1]; /* half a step before these, if `known` is 2 */
    drives_of_lanes now[DRIVES + 1];
    column one[DRIVES + 1][MOMENTS], two[DRIVES + 1][MOMENTS];
    column x0[SIZE + INPUTS + 1], x1[SIZE + INPUTS + 1], x2[SIZE + INPUTS + 1];
    column whole[SIZE + REPORTS], half[SIZE + REPORTS], full[SIZE + REPORTS];
    column ends[ORDER == 4 ? 3 * SIZE : 1], doubted[SEEN + 1], onset[SEEN + 1];
    column coarse[SEEN + 1], middle[SEEN + 1], fine[SEEN + 1];
    column points_half[NUMBERS + 1], points_full[NUMBERS + 1];
    column ripple_half[1], ripple_full[1], row[OUTPUTS + 1];
    column lowest[OUTPUTS + 1], highest[OUTPUTS + 1], sum[OUTPUTS + 1]; /* of totals.c */
    column last_middle[OUTPUTS + 1], last_row[OUTPUTS + 1];
    steps_aside aside;
} block;

typedef struct {
    long runs, samples, rounds, recording, parted, recorded, capacity;
    double tolerance, duration, step, shortest;
    const double *p;      /* parameters, (PARAMETERS, runs) */
    const double *first;  /* first step of each run */
    const double *times;  /* samples, and behind the last one infinity */
    const drive *drives;  /* (runs or 1, DRIVES) */
    const double *limits; /* low and high, (2, ENVELOPE, runs) */
    const double *ranges; /* (runs, JUDGED), of judged outputs, 0 where not known */
    double *rows;         /* (runs, samples, OUTPUTS) */
    double *numbers;      /* (runs, SAID + JUDGED): what is said of a run */
    double *record;       /* pieces of accepted steps: see martensite/simulate/track.py */
    double *states, *extremes; /* of one run at a time, in marching.c */
    long placed;
    double *totals;       /* (runs, 3, OUTPUTS): lowest, highest and integral of outputs; none if nobody asks */
} march;

#define BROUGHT(part, k, which, i) ((part) ? b->two[k][which][i] : b->one[k][which][i])
#define LEVEL(k, i, time, before) value_at(drive_of(m, b->now + (k), k, i), time, b->now[k].cursor[i], before)
#define OF_LANE(column, i) (column)[i]

static void begin_totals(block *b, const column *row, const long long *begins);
static void add_totals(march *m, block *b, const long long *taken);
static void tell_totals(const march *m, const block *b, long run, long i);

INLINE double smaller(double a, double b) { return a < b ? a : b; }
INLINE double larger(double a, double b) { return a > b ? a : b; }

static void copy_lane(const drives_of_lanes *from, long i, drives_of_lanes *to, long j) {
    const char *a = (const char *)from + sizeof(double) * i;
    char *b = (char *)to + sizeof(double) * j;
    for (size_t k = 0; k < sizeof *from; k += sizeof(column)) memcpy(b + k, a + k, sizeof(double));
}

static const drive *drive_of(const march *m, const drives_of_lanes *d, long k, long i) {
    return m->drives + (OWN ? d->run[i] * DRIVES : 0) + k;
}

INLINE unsigned long long any(const flags_of_lanes flags) {
    unsigned long long found = 0;
    EVERY(i) found |= (unsigned long long)(flags[i] != 0) << i;
    return found;
}

/* ------------------------------------------------------------------ drives */

/* series or quotient of sinc and leaning, see reader.c */
static void sincs(const column x, column sinc_x, column leaning_x) {
    double most = 0.0;
    EVERY(i) most = larger(most, fabs(x[i]));
    EACH(i) {
        const double z = x[i] * x[i];
        sinc_x[i] = 1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0) *
                    (1.0 - z * (1.0 / 42.0) * (1.0 - z * (1.0 / 72.0))));
        leaning_x[i] = x[i] * (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0))));
    }
    if (most < SERIES) return;
    EVERY(i) if (!(fabs(x[i]) < SERIES)) {
        sinc_x[i] = sinc(x[i]);
        leaning_x[i] = leaning(x[i]);
    }
}

/* angles of tones in the middle of both halves of a step, turned from those at its start */
static void turn(const drives_of_lanes *d, long j, const column length, column *one, column *two) {
    column x, s, c, unused;
    EACH(i) x[i] = 0.25 * d->speed[j][i] * length[i];
    sincs(x, s, unused);
    EACH(i) {
        s[i] *= x[i];
        c[i] = sqrt(larger(1.0 - s[i] * s[i], 0.0));
    }
    EVERY(i) if (!(x[i] < SERIES)) c[i] = cos(x[i]);
    EACH(i) {
        const double s2 = 2.0 * s[i] * c[i], c2 = 1.0 - 2.0 * s[i] * s[i];
        const double c1 = d->cosine[j][i] * c[i] - d->sine[j][i] * s[i];
        const double s1 = d->sine[j][i] * c[i] + d->cosine[j][i] * s[i];
        one[0][i] = c1;
        one[1][i] = s1;
        two[0][i] = c1 * c2 - s1 * s2;
        two[1][i] = s1 * c2 + c1 * s2;
    }
}

/* moments of intervals in which no segment ends: of a parabola */
static void of_parabola(const drives_of_lanes *d, const column centre, const column half, column *m) {
    EACH(i) {
        const double along = centre[i] - d->start[i], d2 = d->bend[i];
        const double square = half[i] * half[i], third = square * (1.0 / 3.0);
        const double d0 = d->level[i] + (d->slope[i] + d2 * along) * along;
        const double d1 = d->slope[i] + 2.0 * d2 * along;
        const double slant = fabs(d1) * half[i], curve = d2 * square;
        m[MEAN][i] = d0 + d2 * third;
        m[SQUARE][i] = d0 * d0 + (d1 * d1 + 2.0 * d0 * d2) * third + d2 * d2 * square * square * 0.2;
        m[LOW][i] = d0 - slant + smaller(curve, 0.0);
        m[HIGH][i] = d0 + slant + larger(curve, 0.0);
        m[LAPSE][i] = 0.0;
        m[SLOPE][i] = d1;
        m[SQUARE_SLOPE][i] = 2.0 * d1 * (d0 + 0.6 * d2 * square);
    }
}

#if TONES > 0
/* half of the intervals as angles of tones, and functions of them, alone and of pairs */
typedef struct {
    column reach[TONES], share[TONES], lean[TONES], near[TONES][TONES], far[TONES][TONES];
} reaches;

static void find_reaches(const drives_of_lanes *d, const column half, reaches *r) {
    for (long j = 0; j < TONES; j++) {
        EACH(i) r->reach[j][i] = d->speed[j][i] * half[i];
        sincs(r->reach[j], r->share[j], r->lean[j]);
        for (long l = 0; l <= j; l++) {
            column apart, both, unused;
            EACH(i) {
                apart[i] = r->reach[j][i] - r->reach[l][i];
                both[i] = r->reach[j][i] + r->reach[l][i];
            }
            sincs(apart, r->near[j][l], unused);
            sincs(both, r->far[j][l], unused);
        }
    }
}

/* what tones add to levels that are constant; `at` are cosines and sines in the middle */
static void add_tones(const drives_of_lanes *d, const column (*at)[2], const reaches *r,
                      const column half, column *m) {
    column swing, level;
    EACH(i) {
        swing[i] = 0.0;
        level[i] = m[MEAN][i];
    }
    for (long j = 0; j < TONES; j++) {
        EACH(i) {
            const double a = d->amplitude[j][i], size = fabs(a), x = r->reach[j][i];
            const double peak = a * at[j][0][i];
            const double spread = size * fabs(at[j][1][i]) * x + 0.5 * size * x * x;
            m[SQUARE][i] += 2.0 * peak * level[i] * r->share[j][i];
            m[MEAN][i] += peak * r->share[j][i];
            m[SLOPE][i] -= 3.0 / half[i] * a * at[j][1][i] * r->lean[j][i];
            m[LOW][i] += larger(peak - spread, -size);
            m[HIGH][i] += smaller(peak + spread, size);
            swing[i] += x > RESOLVED ? size / d->speed[j][i] : 0.0;
        }
        for (long l = 0; l <= j; l++) {
            EACH(i) {
                const double together = at[l][0][i] * at[j][0][i], crossed = at[l][1][i] * at[j][1][i];
                const double sum = (together + crossed) * r->near[j][l][i] +
                                   (together - crossed) * r->far[j][l][i];
                m[SQUARE][i] += (l == j ? 0.5 : 1.0) * d->amplitude[j][i] * d->amplitude[l][i] * sum;
            }
        }
    }
    EACH(i) {
        const double size = larger(fabs(m[LOW][i]), fabs(m[HIGH][i]));
        m[SQUARE_SLOPE][i] += 2.0 * m[MEAN][i] * m[SLOPE][i];
        m[LAPSE][i] = size > 0.0 ? swing[i] / size : 0.0;
    }
}
#endif

/* whether moments until an end are those of a parabola, or of a constant and tones */
static void find_plain(const drives_of_lanes *d, const column end, flags_of_lanes plain) {
    EACH(i) plain[i] = (d->following[i] >= end[i]) &
                       (TONES == 0 || ((d->slope[i] == 0.0) & (d->bend[i] == 0.0)));
}

static void put_moments(const moments *found, column *m, long i) {
    m[MEAN][i] = found->mean;
    m[SQUARE][i] = found->square;
    m[LOW][i] = found->low;
    m[HIGH][i] = found->high;
    m[LAPSE][i] = found->lapse;
    m[SLOPE][i] = found->slope;
    m[SQUARE_SLOPE][i] = found->square_slope;
}

/* what a drive brings in a part of the step of a run */
static void bring(const march *m, const drives_of_lanes *d, long k, long i, double begin, double end,
                  column *into) {
    const drive *one = drive_of(m, d, k, i);
    const tone_angles at = angles_at(one, 0.5 * (begin + end));
    const moments found = moments_of(one, begin, end, d->cursor[i], &at);
    put_moments(&found, into, i);
}

/* what a drive that heats brings in both halves of the steps, for lanes that ask */
static void bring_halves(const march *m, block *b, long k, const flags_of_lanes asked) {
    const drives_of_lanes *d = b->now + k;
    column one[MOMENTS], two[MOMENTS], half, middle, end, first, last;
    flags_of_lanes plain;
    EACH(i) {
        half[i] = 0.25 * b->length[i];
        first[i] = b->time[i] + half[i];
        middle[i] = b->time[i] + 0.5 * b->length[i];
        last[i] = middle[i] + half[i];
        end[i] = b->time[i] + b->length[i];
    }
    find_plain(d, end, plain);
    EACH(i) plain[i] &= asked[i];
    if (any(plain)) {
        of_parabola(d, first, half, one);
        of_parabola(d, last, half, two);
#if TONES > 0
        column at_one[TONES][2], at_two[TONES][2];
        reaches r;
        find_reaches(d, half, &r);
        for (long j = 0; j < TONES; j++) turn(d, j, b->length, at_one[j], at_two[j]);
        add_tones(d, at_one, &r, half, one);
        add_tones(d, at_two, &r, half, two);
#endif
        for (long j = 0; j < MOMENTS; j++) {
            BLEND(b->one[k][j], plain, one[j]);
            BLEND(b->two[k][j], plain, two[j]);
        }
    }
    EVERY(i) if (asked[i] && !plain[i]) {
        bring(m, d, k, i, b->time[i], middle[i], b->one[k]);
        bring(m, d, k, i, middle[i], end[i], b->two[k]);
    }
    EACH(i) {
        const double most = larger(b->one[k][LAPSE][i], b->two[k][LAPSE][i]);
        b->lapse[i] = asked[i] && most > b->lapse[i] ? most : b->lapse[i];
    }
}

/* what the drives bring in both halves of the steps, for lanes that ask */
static void bring_all(const march *m, block *b, const flags_of_lanes asked) {
    EACH(i) b->lapse[i] = asked[i] ? 0.0 : b->lapse[i];
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] > 1) {
            bring_halves(m, b, k, asked);
            continue;
        }
        EVERY(i) if (asked[i]) {
            const drive *d = drive_of(m, b->now + k, k, i);
            const double middle = b->time[i] + 0.5 * b->length[i], end = b->time[i] + b->length[i];
            b->one[k][MEAN][i] = value_at(d, middle, b->now[k].cursor[i], 1);
            b->two[k][MEAN][i] = value_at(d, end, b->now[k].cursor[i], 1);
        }
    }
}

/* moments of whole steps from those of their halves */
static void join(const block *b, long k, column *whole) {
    const column *one = b->one[k], *two = b->two[k];
    if (widths[k] == 1) {
        memcpy(whole[MEAN], two[MEAN], sizeof(column));
        return;
    }
    EACH(i) {
        const double per = 1.5 / b->length[i];
        whole[MEAN][i] = 0.5 * (one[MEAN][i] + two[MEAN][i]);
        whole[SQUARE][i] = 0.5 * (one[SQUARE][i] + two[SQUARE][i]);
        whole[LOW][i] = smaller(one[LOW][i], two[LOW][i]);
        whole[HIGH][i] = larger(one[HIGH][i], two[HIGH][i]);
        whole[LAPSE][i] = 0.0;
        whole[SLOPE][i] = per * (two[MEAN][i] - one[MEAN][i]) + 0.125 * (one[SLOPE][i] + two[SLOPE][i]);
        whole[SQUARE_SLOPE][i] = per * (two[SQUARE][i] - one[SQUARE][i]) +
                                 0.125 * (one[SQUARE_SLOPE][i] + two[SQUARE_SLOPE][i]);
    }
}

/* the inputs of a step; what is owed goes into the first half and the whole */
static void feed(const column (*found)[MOMENTS], const column *owed, const column length, column *x) {
    for (long k = 0; k < DRIVES; k++) {
        memcpy(x, found[k], sizeof(column) * (widths[k] > 1 ? MOMENTS : 1));
        if (widths[k] > 1 && owed) memcpy(x + MOMENTS, owed[k], sizeof(column));
        if (widths[k] > 1 && !owed) memset(x + MOMENTS, 0, sizeof(column));
        x += widths[k];
    }
    memcpy(x, length, sizeof(column));
}

static void put_signals(const march *m, const block *b, const column time, int before, column *x) {
    for (long k = 0; k < DRIVES; k++)
        EVERY(i) x[k][i] = value_at(drive_of(m, b->now + k, k, i), time[i], b->now[k].cursor[i], before);
}

static void judge_at(const march *m, block *b, const column *states, const column time, int before,
                     column *seen) {
    memcpy(b->x2, states, sizeof(column) * SIZE);
    if (JUDGE_SIGNALS) put_signals(m, b, time, before, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *seen);
}

/* where drives are at the start of steps */
static void find_segments(const march *m, block *b) {
    for (long k = 0; k < DRIVES; k++) {
        drives_of_lanes *d = b->now + k;
        EVERY(i) if (b->fresh[i]) {
            const drive *one = drive_of(m, d, k, i);
            const long now = segment_at(one, b->time[i], d->cursor[i]);
            d->cursor[i] = now;
            d->start[i] = one->start[now];
            d->level[i] = one->level[now];
            d->slope[i] = one->slope[now];
            d->bend[i] = one->bend[now];
            d->following[i] = now + 1 < one->count ? one->start[now + 1] : HUGE_VAL;
        }
        for (long j = 0; j < TONES && widths[k] > 1; j++) {
            /* in loops of their own: no function of vectors gives both */
            EACH(i) d->cosine[j][i] = cos(d->speed[j][i] * b->time[i] + d->phase[j][i]);
            EACH(i) d->sine[j][i] = sin(d->speed[j][i] * b->time[i] + d->phase[j][i]);
        }
    }
}

/* ------------------------------------------------------------------ lengths of steps */

INLINE double reach_end(double length, double end) {
    return length >= (1.0 - STEP_TOLERANCE) * end ? end : length > 0.6 * end ? 0.5 * end : length;
}

/* a length that no signal which prescribes a state makes too long */
static double before_prescribed(const march *m, const block *b, long i, double length, double end) {
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] > 1) continue;
        long count;
        const drive *d = drive_of(m, b->now + k, k, i);
        if (d->fastest > 0.0 && PRESCRIBED / d->fastest < length) length = PRESCRIBED / d->fastest;
        const double far = b->time[i] + (1.0 + STEP_TOLERANCE) * length;
        const double edge = first_edge(d, b->time[i] + SHORTEST * m->duration, far, b->now[k].cursor[i], &count);
        if (count && edge - b->time[i] < end) end = edge - b->time[i];
    }
    return reach_end(length, end);
}

/* a shorter length: to the first edge of a drive that heats, or what resolves its tones */
static double to_edge(const march *m, const block *b, long i) {
    double length = b->length[i];
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] == 1) continue;
        long count;
        const drive *d = drive_of(m, b->now + k, k, i);
        const double far = b->time[i] + (1.0 - STEP_TOLERANCE) * length;
        const double edge = first_edge(d, b->time[i] + SHORTEST * m->duration, far, b->now[k].cursor[i], &count);
        if (count) length = edge - b->time[i];
        if (d->fastest > 0.0 && SWING / d->fastest < length) length = SWING / d->fastest;
    }
    return length;
}

/* a length that ends on the first of few edges; of a run in parts the last one before an edge is
   split */
static double before_few_edges(const march *m, block *b, long i) {
    double length = b->length[i];
    long whole = 0;
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] == 1) continue;
        long count;
        const drive *d = drive_of(m, b->now + k, k, i);
        const double far = b->time[i] + (1.0 + STEP_TOLERANCE) * length;
        const double edge = first_edge(d, b->time[i] + SHORTEST * m->duration, far, b->now[k].cursor[i], &count);
        if (count && count <= FEW) length = reach_end(length, edge - b->time[i]);
        whole |= count && count <= FEW && length >= edge - b->time[i];
    }
    if (!m->parted || !whole || b->split[i]) return length;
    b->split[i] = 1;
    return 0.5 * length;
}

/* whether a signal that prescribes a state jumps at the start of a step */
static int is_jump(const march *m, const block *b, long i) {
    int jumps = 0;
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] > 1) continue;
        const drive *d = drive_of(m, b->now + k, k, i);
        const long cursor = b->now[k].cursor[i];
        jumps |= value_at(d, b->time[i], cursor, 0) != value_at(d, b->time[i], cursor, 1);
    }
    return jumps;
}

/* the length of the next step of lanes that begin one */
static void plan_lengths(const march *m, block *b) {
    column allowed, length;
    int prescribed = 0;
    for (long k = 0; k < DRIVES; k++) prescribed |= widths[k] == 1;
    EACH(i) {
        const double end = m->duration - b->time[i];
        allowed[i] = reach_end(smaller(b->next[i], end), end);
    }
    if (prescribed)
        EVERY(i) if (b->fresh[i]) {
            const double end = m->duration - b->time[i];
            allowed[i] = before_prescribed(m, b, i, smaller(b->next[i], end), end);
        }
    memcpy(length, allowed, sizeof(column));
    /* to the next kink of a law, if all goes on as in the last half step */
    for (long place = 0; place < POINTS; place++)
        for (long k = start_of[place] + 4; k < start_of[place] + size_of_point[place]; k++)
            EACH(i) {
                const double now = b->points[k][i], fallen = b->earlier_points[k][i] - now;
                const int ahead = (now > LEAST_FALL) & (fallen > 0.0);
                const double there = SHORT * now / (ahead ? fallen : 1.0) * b->last_half[i];
                const int late = (KINK_MARGIN * allowed[i] < there) & (m->shortest < there);
                const int kink = ahead & late & (there < length[i]);
                length[i] = kink ? there : length[i];
            }
    if (FOLLOWS)
        EVERY(i) if (b->fresh[i]) {
            b->leaps[i] = is_jump(m, b, i);
            length[i] = b->leaps[i] ? LEAP * allowed[i] : length[i];
        }
    EACH(i) {
        const double planned = length[i] < allowed[i] ? allowed[i] : 0.0;
        b->length[i] = b->fresh[i] ? length[i] : b->length[i];
        b->planned[i] = b->fresh[i] ? planned : b->planned[i];
        b->grows[i] = b->fresh[i] ? MOST_CHANGE : b->grows[i];
    }
}

/* lengths over which the mean of no drive leaves out too much, and what the halves bring */
static void resolve_lengths(const march *m, block *b) {
    flags_of_lanes asked;
    EVERY(i) asked[i] = 1;
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] == 1) continue;
        long inside = 0;
        EVERY(i) inside |= b->now[k].following[i] <= b->time[i] + (1.0 + STEP_TOLERANCE) * b->length[i];
        if (!inside) continue;
        EVERY(i) if (b->live[i]) b->length[i] = before_few_edges(m, b, i);
        break;
    }
    do {
        bring_all(m, b, asked);
        EVERY(i) {
            asked[i] = 0;
            const double heat = JUDGED ? b->scale[0][i] : 1.0;
            if (!b->live[i] || !(b->lapse[i] > 0.0) || b->power[i] * b->lapse[i] <= m->tolerance * heat)
                continue;
            const double shorter = to_edge(m, b, i);
            asked[i] = shorter < b->length[i];
            if (asked[i]) b->length[i] = shorter;
        }
    } while (any(asked));
}

/* ------------------------------------------------------------------ a step */

#if ORDER == 4
/* one step where laws give rates: its end, its middle, and its end to a lower order */
static void solve_steps(block *b, const column (*whole)[MOMENTS]) {
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(whole, 0, b->length, b->x0 + SIZE);
    k_rosenbrock(LANES, *b->c, *b->x0, *b->ends);
    memcpy(b->full, b->ends, sizeof(column) * SIZE);
    memcpy(b->half, b->ends + SIZE, sizeof(column) * SIZE);
    memcpy(b->whole, b->ends + 2 * SIZE, sizeof(column) * SIZE);
}

/* Behind an edge of a drive rates may die out within a part of a step, which no error estimate of
   that step sees: a step of half its length is compared with its middle, and replaces it. */
static void check_middles(const march *m, block *b, const column half, const column middle) {
    column seen[SEEN + 1];
    if (!any(b->at_edge)) return;
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, 0, half, b->x0 + SIZE);
    k_rosenbrock(LANES, *b->c, *b->x0, *b->ends);
    judge_at(m, b, b->ends, middle, 0, seen);
    for (long k = 0; k < SIZE; k++) BLEND(b->half[k], b->at_edge, b->ends[k]);
    memcpy(b->doubted, b->middle, sizeof(column) * SEEN);
    for (long k = 0; k < SEEN; k++) BLEND(b->middle[k], b->at_edge, seen[k]);
}
#else
/* steps in two halves, and the same as wholes */
static void solve_steps(block *b, const column (*whole)[MOMENTS]) {
    column half, gap;
    EACH(i) {
        half[i] = 0.5 * b->length[i];
        gap[i] = 0.5 * (b->last_half[i] + half[i]);
    }
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, b->owed, half, b->x0 + SIZE);
    for (long k = 0; k < RATES; k++) {
        column *x = b->x0 + rates[k];
        EACH(i) (*x)[i] += gap[i] / b->last_half[i] * ((*x)[i] - b->rate[k][i]);
    }
    k_solve(LANES, *b->c, *b->x0, *b->half);
    memcpy(b->x1, b->half, sizeof(column) * SIZE);
    feed(b->two, 0, half, b->x1 + SIZE);
    for (long k = 0; k < RATES; k++) {
        column *x = b->x1 + rates[k];
        EACH(i) (*x)[i] += half[i] / gap[i] * (b->half[rates[k]][i] - b->state[rates[k]][i]);
    }
    k_solve(LANES, *b->c, *b->x1, *b->full);
    feed(whole, b->owed, b->length, b->x0 + SIZE);
    for (long k = 0; k < RATES; k++) {
        column *x = b->x0 + rates[k];
        EACH(i) (*x)[i] = 0.5 * (b->half[rates[k]][i] + b->full[rates[k]][i]);
    }
    k_solve(LANES, *b->c, *b->x0, *b->whole);
}

static void check_middles(const march *m, block *b, const column half, const column middle) {
    (void)m, (void)b, (void)half, (void)middle;
}
#endif

/* what the means of the drives leave out in each half */
static void find_ripples(block *b, const column half) {
    double lapse = 0.0;
    EVERY(i) lapse = larger(lapse, b->lapse[i]);
    if (!(lapse > 0.0)) return;
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, b->owed, half, b->x0 + SIZE);
    k_ripple(LANES, *b->c, *b->x0, *b->ripple_half);
    memcpy(b->x1, b->half, sizeof(column) * SIZE);
    feed(b->two, 0, half, b->x1 + SIZE);
    k_ripple(LANES, *b->c, *b->x1, *b->ripple_full);
}

static void try_steps(const march *m, block *b) {
    column whole[DRIVES + 1][MOMENTS], half, end, middle;
    for (long k = 0; k < DRIVES; k++) join(b, k, whole[k]);
    EACH(i) {
        half[i] = 0.5 * b->length[i];
        middle[i] = b->time[i] + half[i];
        end[i] = b->time[i] + b->length[i];
    }
    solve_steps(b, whole);
    find_ripples(b, half);
    k_points(LANES, *b->c, *b->half, *b->points_half);
    k_points(LANES, *b->c, *b->full, *b->points_full);
    judge_at(m, b, b->whole, end, 1, b->coarse);
    judge_at(m, b, b->half, middle, 0, b->middle);
    judge_at(m, b, b->full, end, 1, b->fine);
    check_middles(m, b, half, middle);
    if (FOLLOWS) judge_at(m, b, b->state, b->time, 0, b->onset);
}

/* share of a step at which a number falls to 0; else 1 */
static double find_fall(double ahead, double first, double middle, double last) {
    if (!(first > LEAST_FALL && (middle <= 0.0 || last <= 0.0))) return 1.0;
    const int late = middle > 0.0;
    const double begin = late ? 0.5 : 0.0, top = late ? middle : first;
    const double bottom = late ? last : middle;
    if (late) ahead = first - middle;
    return begin + 0.5 * (ahead > top ? top / ahead : top / (top - bottom));
}

/* share of a step at which what drives the law at a point turns, if that counts; else 1 */
INLINE double find_turn(const block *b, long at, long i, double changed, double most) {
    const column *p = b->earlier_points + at, *q = b->points + at;
    const column *a = b->points_half + at, *z = b->points_full + at;
    const double e = p[0][i] - p[1][i] * PER_STRESS, f = q[0][i] - q[1][i] * PER_STRESS;
    const double g = a[0][i] - a[1][i] * PER_STRESS, h = z[0][i] - z[1][i] * PER_STRESS;
    const double bend = (h - g) - (g - f), rise = h - f;
    const int turns = fabs(rise) < 2.0 * fabs(bend);
    const double per = 1.0 / (turns ? bend : 1.0), top = g - 0.125 * rise * rise * per;
    const double share = 0.5 - 0.25 * rise * per;
    const double moved = fabs(f - e) + fabs(g - f) + fabs(h - g);
    const double apart = smaller(smaller(fabs(top - f), fabs(top - g)), fabs(top - h));
    const int counts = turns & (changed > most) & (BESIDE < share) & (share < 1.0 - BESIDE) &
                       (changed * apart > most * moved);
    return counts ? share : 1.0;
}

/* whether a step misses much of a bend near one of its ends, which its error does not show */
static int hides_bend(const block *b, long at, long i, double share, double allowed) {
    const double ratio = 0.5 * b->length[i] / b->last_half[i];
    const int late = share > 0.5;
    double most = 0.0;
    if (!(0.0 < share && share < EDGE) && !(1.0 - EDGE < share && share < 1.0 - BESIDE)) return 0;
    for (long k = at + 2; k < at + 4; k++) {
        const double e = b->earlier_points[k][i], f = b->points[k][i];
        const double g = b->points_half[k][i], h = b->points_full[k][i];
        const double missed = late ? fabs((h - g) - (g - f)) : 2.0 * share * fabs((g - f) - ratio * (f - e));
        most = missed > most ? missed : most;
    }
    return most > allowed;
}

/* share of a step at which the law at a point bends, if that counts; else 1 */
static double find_bend(const block *b, long place, long i, double most) {
    const long at = start_of[place];
    const column *p = b->earlier_points + at, *q = b->points + at;
    const column *a = b->points_half + at, *z = b->points_full + at;
    const double ratio = 0.5 * b->length[i] / b->last_half[i];
    double first = 1.0;
    for (long k = 4; k < size_of_point[place]; k++) {
        const double ahead = ratio * (p[k][i] - q[k][i]);
        const double share = find_fall(ahead, q[k][i], a[k][i], z[k][i]);
        const int seen = b->error[i] > 1.0 && BESIDE < share && share < 1.0 - BESIDE;
        if (share < first && (seen || hides_bend(b, at, i, share, HIDDEN / TURN * most))) first = share;
    }
    return first;
}

/* share of each step at which its law turns or bends; 1 if that does not count */
static void find_kinks(const march *m, block *b) {
    EACH(i) b->kink[i] = 1.0;
    for (long place = 0; place < POINTS; place++) {
        const long at = start_of[place];
        /* numbers that turn, and may pass 0 there and nowhere else */
        for (long k = at + 4; k < at + size_of_point[place]; k++)
            EACH(i) {
                const double f = b->points[k][i], g = b->points_half[k][i], h = b->points_full[k][i];
                const double bend = (h - g) - (g - f), rise = h - f, least = smaller(smaller(f, h), g);
                const int turns = (least > LEAST_FALL) & (fabs(rise) < 2.0 * bend);
                const double per = 1.0 / (turns ? bend : 1.0), low = g - 0.125 * rise * rise * per;
                const double share = 0.5 - 0.25 * rise * per;
                const int dips = turns & (low + low < least) & (BESIDE < share) &
                                 (share < 1.0 - BESIDE) & (share < b->kink[i]);
                b->kink[i] = dips ? share : b->kink[i];
            }
        const double share = TURN * m->tolerance / weights[place];
        column changed, most;
        long counts = 0;
        EACH(i) changed[i] = 0.0;
        for (long k = at + 2; k < at + 4; k++)
            EACH(i) {
                const double sum = fabs(b->points[k][i] - b->earlier_points[k][i]) +
                                   fabs(b->points_half[k][i] - b->points[k][i]) +
                                   fabs(b->points_full[k][i] - b->points_half[k][i]);
                changed[i] = larger(changed[i], sum);
            }
        EACH(i) most[i] = share * b->scale[parts[place]][i];
        EVERY(i) counts |= changed[i] > most[i];
        if (!counts) continue;
        EACH(i) b->kink[i] = smaller(find_turn(b, at, i, changed[i], most[i]), b->kink[i]);
        EVERY(i) if (changed[i] > most[i])
            b->kink[i] = smaller(find_bend(b, place, i, most[i]), b->kink[i]);
    }
}

/* errors of the steps as shares of the tolerance; infinite where they are not solved */
static void judge_errors(const march *m, block *b, column ripple, column residual) {
    const double per = 1.0 / m->tolerance;
    column broken;
    EACH(i) {
        const double a = b->whole[SIZE][i], c = b->half[SIZE][i], e = b->full[SIZE][i];
        const double ac = a <= c ? c : a;
        residual[i] = ac <= e ? e : ac;
        const double most = larger(b->ripple_half[0][i], b->ripple_full[0][i]);
        ripple[i] = b->lapse[i] > 0.0 ? most : 0.0;
        b->power[i] = b->lapse[i] > 0.0 ? most / b->lapse[i] : b->power[i];
        b->error[i] = broken[i] = 0.0;
    }
    for (long k = 0; k < SEEN; k++)
        EACH(i) broken[i] += 0.0 * b->fine[k][i] + 0.0 * b->coarse[k][i];
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double apart = PART * fabs(b->fine[k][i] - b->coarse[k][i]);
            const double wider = larger(b->fine[k][i] - b->low[k][i], b->high[k][i] - b->fine[k][i]);
            const double most = k ? apart : larger(apart, ripple[i]);
            b->error[i] = larger(b->error[i], most / larger(b->scale[k][i], wider) * per);
        }
    for (long k = 0; k < JUDGED && ORDER == 4; k++)
        EACH(i) {
            const double apart = fabs(b->middle[k][i] - b->doubted[k][i]) / b->scale[k][i] * per;
            b->error[i] = larger(b->error[i], b->at_edge[i] ? apart : 0.0);
        }
    for (long k = 0; k < JUDGED && FOLLOWS; k++)
        EACH(i) {
            const double bend = fabs(b->onset[k][i] - 2.0 * b->middle[k][i] + b->fine[k][i]);
            b->error[i] = larger(b->error[i], b->leaps[i] ? 0.0 : BEND * bend / b->scale[k][i] * per);
        }
    EACH(i) b->error[i] = broken[i] == 0.0 && residual[i] <= SOLVED ? b->error[i] : HUGE_VAL;
}

/* which steps are taken, and how long the next trial of each is */
static void judge_steps(const march *m, block *b, flags_of_lanes taken) {
    const double shortest = m->shortest;
    column ripple, residual, change, rough, slowing;
    judge_errors(m, b, ripple, residual);
    find_kinks(m, b);
    EACH(i) {
        const long last = b->length[i] <= shortest, solved = b->error[i] < HUGE_VAL;
        const long good = b->error[i] <= 1.0;
        b->kink[i] = solved && !last ? b->kink[i] : 1.0;
        taken[i] = b->live[i] && (last || (good && b->kink[i] == 1.0));
        const double error = last && !good ? 1.0 : b->error[i];
        const double used = smaller(larger(error, LEAST_ERROR), 1e300), length = b->length[i];
        const double cube = length * length * length;
        rough[i] = used / (ORDER == 4 ? cube * length : cube);
        const double falls = b->rough[i] > 0.0 && b->rough[i] < rough[i] ? b->rough[i] / rough[i] : 1.0;
        change[i] = SAFETY * exp(-POWER * log(used));
        slowing[i] = change[i] * exp(POWER * log(falls));
    }
    EVERY(i) if (b->live[i] && b->length[i] <= shortest && b->error[i] == HUGE_VAL)
        b->status[i] = residual[i] > SOLVED ? UNSOLVED : NOT_FINITE;
    /* steps that are taken */
    EACH(i) {
        const long t = taken[i], kinked = b->planned[i] > 0.0;
        const double length = b->length[i], grows = smaller(slowing[i], b->grows[i]);
        const double grown = length * larger(grows, LEAST_CHANGE);
        const double after_kink = b->at_kink[i] ? MOST_CHANGE * length : b->after_kink[i];
        const double bound = !kinked || after_kink > grown ? after_kink : grown;
        const double planned = larger(grown, b->planned[i]);
        const double next = larger(kinked ? smaller(planned, bound) : planned, shortest);
        b->ripple[i] = t ? larger(ripple[i], b->ripple[i]) : b->ripple[i];
        const int missed = b->error[i] > 1.0 && b->error[i] < HUGE_VAL; /* no step is shorter */
        const double left = larger(residual[i], b->residual[i]) + (missed ? m->tolerance * b->error[i] : 0.0);
        b->residual[i] = t ? left : b->residual[i];
        b->after_kink[i] = t ? after_kink : b->after_kink[i];
        b->at_kink[i] = t ? kinked : b->at_kink[i];
        b->rough[i] = t ? (kinked ? 0.0 : rough[i]) : b->rough[i];
        b->next[i] = t ? next : b->next[i];
    }
    /* those that are made again */
    flags_of_lanes again;
    EACH(i) again[i] = b->live[i] & !taken[i];
    SOME(i, any(again)) {
        const double length = b->length[i];
        const int solved = b->error[i] < HUGE_VAL, good = b->error[i] <= 1.0;
        double shorter = solved ? length : 0.25 * length;
        b->rejected[i] += 1.0;
        if (good)
            b->planned[i] = larger(length, b->planned[i]);
        else
            b->grows[i] = 1.0;
        if (b->kink[i] < 1.0) {
            shorter = b->kink[i] * length;
        } else if (solved) {
            shorter = length * smaller(larger(change[i], LEAST_CHANGE), SAFETY);
            if (b->power[i] * b->lapse[i] > m->tolerance * (JUDGED ? b->scale[0][i] : 1.0))
                shorter = smaller(shorter, to_edge(m, b, i));
        }
        b->length[i] = larger(shorter, 0.5 * shortest);
    }
}

/* ------------------------------------------------------------------ samples */

static long is_judged_state(long k) {
    for (long i = 0; i < RATES; i++)
        if (rates[i] == k) return 0;
    return 1;
}

/* Whether the polynomial through the last five points is good enough in each step; the inverse
   denominators of its weights. Its own last term is small enough, or, where a sixth point is known,
   the one that would come next. */
static void find_smooth(const march *m, const block *b, flags_of_lanes smooth, column *per) {
    column reached, farther, over;
    flags_of_lanes flat, flatter;
    EACH(i) {
        const double half = 0.5 * b->length[i], t2 = b->time[i], tail = b->older_time[i];
        const double t[5] = {b->node_time[0][i], b->node_time[1][i], t2, t2 + half, t2 + b->length[i]};
        const double cubic = CUBIC * half * half * half, long_way = t[4] - tail;
        reached[i] = cubic * (t[4] - t[1]);
        farther[i] = cubic * (t[4] - t[1]) * (t[4] - t[0]);
        for (long j = 0; j < 5; j++) {
            double product = 1.0;
            for (long k = 0; k < 5; k++) product *= k == j ? 1.0 : t[j] - t[k];
            per[j][i] = 1.0 / product;
        }
        over[i] = 1.0 / ((tail - t[0]) * (tail - t[1]) * (tail - t[2]) * (tail - t[3]) * -long_way);
        flat[i] = flatter[i] = 1;
    }
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double t2 = b->time[i], tail = b->older_time[i];
            const double a = per[0][i] * b->node_seen[0][k][i], c = per[1][i] * b->node_seen[1][k][i];
            const double d = per[2][i] * b->seen[k][i], e = per[3][i] * b->middle[k][i];
            const double f = per[4][i] * b->fine[k][i];
            const double fifth = a / (b->node_time[0][i] - tail) + c / (b->node_time[1][i] - tail) +
                                 d / (t2 - tail) + e / (t2 + 0.5 * b->length[i] - tail) +
                                 f / (t2 + b->length[i] - tail) + over[i] * b->older_seen[k][i];
            const double allowed = BETWEEN * m->tolerance * b->scale[k][i];
            flat[i] &= reached[i] * fabs(a + c + d + e + f) <= allowed;
            flatter[i] &= farther[i] * fabs(fifth) <= allowed;
        }
    EACH(i) smooth[i] = (b->known[i] > 0) & !(b->lapse[i] > 0.0) &
                        (flat[i] | (flatter[i] & (b->known[i] > 1)));
}

/* states on it at times; those that overshoot what they go through are no longer smooth */
static void interpolate(const block *b, const column time, const column *per, flags_of_lanes smooth,
                        column *x, long all) {
    column w[5];
    EACH(i) {
        const double t0 = time[i] - b->node_time[0][i], t1 = time[i] - b->node_time[1][i];
        const double t2 = time[i] - b->time[i], t3 = t2 - 0.5 * b->length[i], t4 = t2 - b->length[i];
        const double low = t0 * t1, high = t3 * t4;
        w[0][i] = per[0][i] * t1 * t2 * high;
        w[1][i] = per[1][i] * t0 * t2 * high;
        w[2][i] = per[2][i] * low * high;
        w[3][i] = per[3][i] * low * t2 * t4;
        w[4][i] = per[4][i] * low * t2 * t3;
    }
    for (long k = 0; k < SIZE; k++) {
        const long counts = is_judged_state(k);
        if (!(all || observed[k])) continue;
        EACH(i) {
            const double at0 = b->node_state[0][k][i], at1 = b->node_state[1][k][i];
            const double at2 = b->state[k][i], at3 = b->half[k][i], at4 = b->full[k][i];
            const double least = smaller(smaller(smaller(at0, at1), smaller(at2, at3)), at4);
            const double most = larger(larger(larger(at0, at1), larger(at2, at3)), at4);
            const double sum = w[0][i] * at0 + w[1][i] * at1 + w[2][i] * at2 + w[3][i] * at3 + w[4][i] * at4;
            const double hair = ROUNDING * (fabs(least) + fabs(most));
            const long inside = (least - hair <= sum) & (sum <= most + hair);
            smooth[i] = smooth[i] && (inside || !counts);
            x[k][i] = smaller(larger(sum, least), most);
        }
    }
}

INLINE int is_inside(const block *b, const column *seen, long k, long i) {
    return b->limits[k][i] <= seen[JUDGED + k][i] &&
           seen[JUDGED + k][i] <= b->limits[ENVELOPE + k][i];
}

/* whether states are within the envelope */
static void find_gone(const march *m, const column *c, column *x, const column *signals,
                      const flags_of_lanes run, flags_of_lanes gone) {
    column seen[SEEN + 1];
    if (JUDGE_SIGNALS) memcpy(x + SIZE, signals, sizeof(column) * DRIVES);
    k_judge(LANES, *c, *x, *seen);
    EVERY(i) {
        gone[i] = 0;
        for (long k = 0; k < ENVELOPE; k++) {
            const double value = seen[JUDGED + k][i], low = m->limits[k * m->runs + run[i]];
            gone[i] |= !(low <= value && value <= m->limits[(ENVELOPE + k) * m->runs + run[i]]);
        }
    }
}

/* make the steps aside, and keep the outputs at their ends */
static void finish_aside(const march *m, steps_aside *q) {
    column found[DRIVES + 1][MOMENTS], length, half, centre, signals[DRIVES + 1];
    flags_of_lanes gone = {0}, plain;
    long leaving = 0;
    if (!q->count) return;
    for (long j = q->count; j < LANES; j++) { /* the last one fills what is left */
        double *to = (double *)q->c, *x = (double *)q->x;
        for (long k = 0; k < CONSTANTS; k++) to[k * LANES + j] = to[k * LANES + q->count - 1];
        for (long k = 0; k < SIZE; k++) x[k * LANES + j] = x[k * LANES + q->count - 1];
        q->begin[j] = q->begin[q->count - 1];
        q->end[j] = q->end[q->count - 1];
        q->run[j] = q->run[q->count - 1];
        for (long k = 0; k < DRIVES; k++) q->owed[k][j] = q->owed[k][q->count - 1];
        for (long k = 0; k < DRIVES; k++) copy_lane(q->then + k, q->count - 1, q->then + k, j);
    }
    EACH(i) {
        length[i] = q->end[i] - q->begin[i];
        half[i] = 0.5 * length[i];
        centre[i] = q->begin[i] + half[i];
    }
    for (long k = 0; k < DRIVES; k++) {
        drives_of_lanes *d = q->then + k;
        if (widths[k] == 1) {
            EVERY(i) found[k][MEAN][i] = value_at(drive_of(m, d, k, i), q->end[i], d->cursor[i], 1);
            continue;
        }
        find_plain(d, q->end, plain);
        of_parabola(d, centre, half, found[k]);
#if TONES > 0
        column at[TONES][2];
        reaches r;
        find_reaches(d, half, &r);
        for (long j = 0; j < TONES; j++) {
            EACH(i) at[j][0][i] = cos(d->speed[j][i] * centre[i] + d->phase[j][i]);
            EACH(i) at[j][1][i] = sin(d->speed[j][i] * centre[i] + d->phase[j][i]);
        }
        add_tones(d, at, &r, half, found[k]);
#endif
        EVERY(i) if (!plain[i]) bring(m, d, k, i, q->begin[i], q->end[i], found[k]);
    }
    feed(found, q->owed, length, q->x + SIZE);
#if ORDER == 4
    k_rosenbrock(LANES, *q->c, *q->x, *q->y);
#else
    k_solve(LANES, *q->c, *q->x, *q->y);
    for (long k = 0; k < SIZE; k++)
        EACH(i) q->y[k][i] = q->y[SIZE][i] <= SOLVED ? q->y[k][i] : q->line[k][i];
#endif
    memcpy(q->x, q->y, sizeof(column) * SIZE);
    for (long k = 0; k < DRIVES && (OBSERVE_SIGNALS || JUDGE_SIGNALS); k++)
        EVERY(i) signals[k][i] = value_at(drive_of(m, q->then + k, k, i), q->end[i], q->then[k].cursor[i], 0);
    for (long i = 0; i < q->count; i++) leaving |= q->leaving[i];
    if (leaving) find_gone(m, q->c, q->x, signals, q->run, gone);
    if (OBSERVE_SIGNALS) memcpy(q->x + SIZE, signals, sizeof(column) * DRIVES);
    k_observe(LANES, *q->c, *q->x, *q->row);
    for (long i = 0; i < q->count; i++) {
        double *row = m->rows + (q->run[i] * m->samples + q->sample[i]) * OUTPUTS;
        for (long k = 0; k < OUTPUTS && !(q->leaving[i] && gone[i]); k++) row[k] = q->row[k][i];
    }
    q->count = 0;
}

/* a step to the next sample of a run from the start or the middle of the one taken, for later */
static void put_aside(const march *m, block *b, long i, double time, long leaving) {
    steps_aside *q = &b->aside;
    const double middle = b->time[i] + 0.5 * b->length[i];
    const int late = ORDER == 2 && time > middle;
    const column *state = late ? b->half : b->state;
    const long j = q->count++;
    q->run[j] = b->run[i];
    q->sample[j] = b->sample[i];
    q->leaving[j] = leaving;
    q->begin[j] = late ? middle : b->time[i];
    q->end[j] = time;
    for (long k = 0; k < CONSTANTS; k++) q->c[k][j] = b->c[k][i];
    for (long k = 0; k < SIZE; k++) q->x[k][j] = state[k][i];
#if ORDER == 2
    const column *ahead = late ? b->full : b->half;
    const double share = (time - q->begin[j]) / (0.5 * b->length[i]);
    for (long k = 0; k < SIZE; k++) q->line[k][j] = state[k][i] + share * (ahead[k][i] - state[k][i]);
#endif
    for (long k = 0; k < DRIVES; k++) {
        q->owed[k][j] = late ? 0.0 : b->owed[k][i];
        copy_lane(b->now + k, i, q->then + k, j);
    }
    if (q->count == LANES) finish_aside(m, q);
}

/* outputs of the states in x2, for lanes that ask and are inside the envelope */
static void keep_rows(const march *m, block *b, const column time, unsigned long long asked, long leaving) {
    flags_of_lanes gone = {0};
    column signals[DRIVES + 1];
    if (OBSERVE_SIGNALS || (leaving && JUDGE_SIGNALS)) put_signals(m, b, time, 0, signals);
    if (leaving) find_gone(m, b->c, b->x2, signals, b->run, gone);
    if (OBSERVE_SIGNALS) memcpy(b->x2 + SIZE, signals, sizeof(column) * DRIVES);
    k_observe(LANES, *b->c, *b->x2, *b->row);
    SOME(i, asked) if (!gone[i]) {
        double *row = m->rows + (b->run[i] * m->samples + b->sample[i]) * OUTPUTS;
        for (long k = 0; k < OUTPUTS; k++) row[k] = b->row[k][i];
    }
}

/* outputs at the samples within the steps that were taken */
static void keep_samples(const march *m, block *b, const flags_of_lanes taken, const column end) {
    column time, per[5], last, middle;
    flags_of_lanes due, smooth, good, other;
    long leaving = 0, found = 0;
    for (long k = 0; k < ENVELOPE; k++) EVERY(i) leaving |= taken[i] & !is_inside(b, b->fine, k, i);
    EACH(i) {
        last[i] = taken[i] ? end[i] + STEP_TOLERANCE * b->length[i] : -1.0;
        middle[i] = b->time[i] + 0.5 * b->length[i];
    }
    for (;;) {
        EACH(i) {
            due[i] = b->coming[i] <= last[i];
            time[i] = due[i] ? b->coming[i] : end[i];
        }
        if (!any(due)) return;
        if (!found) find_smooth(m, b, smooth, per);
        found = 1;
        memcpy(good, smooth, sizeof good);
        interpolate(b, time, per, good, b->x2, leaving);
        EACH(i) other[i] = due[i] & (!good[i] | (time[i] >= end[i] - STEP_TOLERANCE * b->length[i]));
        SOME(i, any(other)) {
            const double hair = STEP_TOLERANCE * b->length[i];
            const int ends = time[i] >= end[i] - hair, halves = fabs(time[i] - middle[i]) <= hair;
            if (ends || halves) {
                for (long k = 0; k < SIZE; k++) b->x2[k][i] = ends ? b->full[k][i] : b->half[k][i];
            } else {
                put_aside(m, b, i, time[i], leaving);
                good[i] = -1; /* it is kept later */
            }
        }
        EACH(i) other[i] = due[i] & (good[i] >= 0);
        const unsigned long long shown = any(other);
        if (shown) keep_rows(m, b, time, shown, leaving);
        EACH(i) {
            b->sample[i] += due[i];
            b->coming[i] = m->times[b->sample[i]];
        }
    }
}

/* ------------------------------------------------------------------ the way through time */

static void tell(const march *m, block *b, long i) {
    double *n = m->numbers + b->run[i] * (SAID + JUDGED); /* no ledger of heat and work is among them */
    n[0] = (double)b->status[i];
    n[1] = b->time[i];
    n[2] = (double)b->place[i];
    n[3] = b->place[i] < 0 ? 0.0 : b->seen[JUDGED + b->place[i]][i];
    n[4] = b->steps[i];
    n[5] = b->rejected[i];
    n[6] = b->longest[i];
    n[7] = b->ripple[i];
    n[8] = b->residual[i];
    for (long k = 0; k < JUDGED; k++) n[SAID + k] = b->high[k][i] - b->low[k][i];
    tell_totals(m, b, b->run[i], i);
    b->live[i] = 0;
    b->loaded[i] = b->status[i] < UNSOLVED; /* what has failed may take long to solve, again and again */
    b->done++;
}

static void scale_ranges(block *b) {
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double least = larger(b->range[k][i], floors[k]);
            b->scale[k][i] = larger(b->high[k][i] - b->low[k][i], least);
        }
}

/* runs that are outside of the envelope, at the end, or cannot go on, end here */
static void end_runs(const march *m, block *b) {
    long outside = 0, ends = 0;
    for (long k = 0; k < ENVELOPE; k++) EVERY(i) outside |= !is_inside(b, b->seen, k, i);
    for (long k = 0; k < ENVELOPE && outside; k++)
        EVERY(i) if (b->live[i] && b->status[i] < UNSOLVED && !is_inside(b, b->seen, k, i)) {
            b->status[i] = isfinite(b->seen[JUDGED + k][i]) ? OUT_OF_ENVELOPE : NOT_FINITE;
            b->place[i] = k;
        }
    EVERY(i) ends |= b->live[i] && (b->status[i] >= UNSOLVED || !(b->time[i] < m->duration));
    if (!ends) return;
    EVERY(i) if (b->live[i] && (b->status[i] >= UNSOLVED || !(b->time[i] < m->duration))) tell(m, b, i);
}

/* whether a drive has an edge at the end of a step */
static long is_edge(const march *m, const block *b, long i, double end) {
    const double hair = STEP_TOLERANCE * b->length[i];
    for (long k = 0; k < DRIVES; k++) {
        long count;
        first_edge(drive_of(m, b->now + k, k, i), end - hair, end + hair, b->now[k].cursor[i], &count);
        if (count) return 1;
    }
    return 0;
}

/* a piece of an accepted step of a run, and the state at its end, in the layout of martensite/simulate/track.py */
static void record_piece(march *m, const block *b, long i, double part, double begin, double end,
                         const column (*brought)[MOMENTS], const column *states) {
    if (!m->recording) return;
    double *row = m->record + m->recorded++ * RECORDED;
    *row++ = (double)b->run[i];
    *row++ = part;
    *row++ = begin;
    *row++ = end - begin;
    for (long k = 0; k < DRIVES; k++) {
        const drive *d = drive_of(m, b->now + k, k, i);
        const double after = level_at(d, begin, b->now[k].cursor[i], 0);
        const int wide = widths[k] > 1 && part >= 0.0;
        *row++ = after;
        *row++ = part < 0.0 ? after : level_at(d, end, b->now[k].cursor[i], 1);
        *row++ = wide ? brought[k][MEAN][i] : after;
        *row++ = wide ? brought[k][SQUARE][i] : after * after;
        *row++ = wide ? brought[k][LOW][i] : after;
        *row++ = wide ? brought[k][HIGH][i] : after;
        *row++ = wide ? brought[k][LAPSE][i] : 0.0;
    }
    for (long k = 0; k < SIZE; k++)
        if (observed[k]) *row++ = states[k][i];
}

static void accept_steps(march *m, block *b, flags_of_lanes taken) {
    column end;
    flags_of_lanes edge;
    EVERY(i) if (taken[i] && b->status[i] != OK) { /* it has no solution here, and ends where it began */
        tell(m, b, i);
        taken[i] = 0;
    }
    if (!any(taken)) return;
    EACH(i) {
        end[i] = b->time[i] + b->length[i];
        end[i] = m->duration - end[i] < SHORTEST * m->duration ? m->duration : end[i];
        edge[i] = 0;
    }
    for (long k = 0; k < DRIVES; k++) {
        long near = 0;
        EVERY(i) near |= b->now[k].following[i] < end[i] + 2.0 * STEP_TOLERANCE * b->length[i];
        if (!near) continue;
        EVERY(i) if (taken[i]) edge[i] = is_edge(m, b, i, end[i]);
        break;
    }
    keep_samples(m, b, taken, end);
    EVERY(i) if (taken[i] && b->live[i]) {
        const double middle = b->time[i] + 0.5 * b->length[i];
        record_piece(m, b, i, 1.0, b->time[i], middle, b->one, b->half);
        record_piece(m, b, i, 2.0, middle, end[i], b->two, b->full);
    }
    long long counted[LANES];
    EVERY(i) {
        counted[i] = taken[i] && b->live[i];
        for (long k = 0; k < ENVELOPE; k++) counted[i] &= is_inside(b, b->fine, k, i);
    }
    add_totals(m, b, counted);
    EACH(i) {
        const long t = taken[i], at = edge[i];
        const double length = b->length[i];
        const double after_edge = b->at_edge[i] && !b->leaps[i] ? MOST_CHANGE * length : b->after_edge[i];
        b->steps[i] += t ? (ORDER == 4 ? 1.0 : 2.0) : 0.0;
        b->longest[i] = t ? larger(ORDER == 4 ? length : 0.5 * length, b->longest[i]) : b->longest[i];
        b->after_edge[i] = t ? after_edge : b->after_edge[i];
        b->next[i] = t && at ? smaller(b->next[i], after_edge) : b->next[i];
        b->rough[i] = t && at ? 0.0 : b->rough[i];
        b->at_edge[i] = t ? at : b->at_edge[i];
        const long more = b->known[i] < 2 ? b->known[i] + 1 : 2;
        b->known[i] = t ? (at | (b->lapse[i] > 0.0) ? 0 : more) : b->known[i];
        b->older_time[i] = t ? b->node_time[1][i] : b->older_time[i];
        b->split[i] &= !(t & at);
        b->last_half[i] = t ? 0.5 * length : b->last_half[i];
        b->node_time[0][i] = t ? b->time[i] : b->node_time[0][i];
        b->node_time[1][i] = t ? b->time[i] + 0.5 * length : b->node_time[1][i];
        b->time[i] = t ? end[i] : b->time[i];
        b->fresh[i] = t;
    }
    for (long k = 0; k < RATES; k++) BLEND(b->rate[k], taken, b->half[rates[k]]);
    for (long k = 0; k < SIZE; k++) {
        BLEND(b->node_state[0][k], taken, b->state[k]);
        BLEND(b->node_state[1][k], taken, b->half[k]);
        BLEND(b->state[k], taken, b->full[k]);
    }
    for (long k = 0; k < JUDGED; k++) {
        BLEND(b->older_seen[k], taken, b->node_seen[1][k]);
        BLEND(b->node_seen[0][k], taken, b->seen[k]);
        BLEND(b->node_seen[1][k], taken, b->middle[k]);
        EACH(i) {
            b->low[k][i] = taken[i] ? smaller(b->fine[k][i], b->low[k][i]) : b->low[k][i];
            b->high[k][i] = taken[i] ? larger(b->fine[k][i], b->high[k][i]) : b->high[k][i];
        }
    }
    for (long k = 0; k < NUMBERS; k++) {
        BLEND(b->earlier_points[k], taken, b->points_half[k]);
        BLEND(b->points[k], taken, b->points_full[k]);
    }
    for (long k = 0; k < HEATED && ORDER == 2; k++) {
        const double *fine = b->fine[JUDGED + ENVELOPE + k], *coarse = b->coarse[JUDGED + ENVELOPE + k];
        EACH(i) {
            const double owed = PART * (fine[i] - coarse[i]);
            b->owed[places[k]][i] = taken[i] ? owed : b->owed[places[k]][i];
        }
    }
    for (long k = 0; k < SEEN; k++) BLEND(b->seen[k], taken, b->fine[k]);
    scale_ranges(b);
    end_runs(m, b);
}

/* ------------------------------------------------------------------ runs */

/* what is known of a run before it begins */
static void load_run(const march *m, block *b, long i, long run) {
    b->run[i] = run;
    b->status[i] = OK;
    b->place[i] = -1;
    b->sample[i] = b->at_edge[i] = 1;
    b->coming[i] = m->times[1];
    b->at_kink[i] = b->known[i] = b->split[i] = 0;
    b->time[i] = b->power[i] = b->lapse[i] = b->rough[i] = b->steps[i] = b->rejected[i] = 0.0;
    b->longest[i] = b->ripple[i] = b->residual[i] = 0.0;
    b->next[i] = b->after_edge[i] = b->last_half[i] = b->length[i] = m->first[run];
    b->after_kink[i] = HUGE_VAL;
    for (long k = 0; k < PARAMETERS; k++) b->p[k][i] = m->p[k * m->runs + run];
    for (long k = 0; k < 2 * ENVELOPE; k++) b->limits[k][i] = m->limits[k * m->runs + run];
    for (long k = 0; k < JUDGED; k++) b->range[k][i] = m->ranges[run * JUDGED + k];
    for (long k = 0; k < RATES; k++) b->rate[k][i] = 0.0;
    for (long k = 0; k < DRIVES; k++) {
        b->now[k].run[i] = run;
        b->now[k].cursor[i] = 0;
        const drive *d = drive_of(m, b->now + k, k, i);
        b->owed[k][i] = 0.0;
        for (long j = 0; j < TONES; j++) {
            b->now[k].amplitude[j][i] = j < d->tones ? d->amplitude[j] : 0.0;
            b->now[k].speed[j][i] = j < d->tones ? d->rate[j] : 0.0;
            b->now[k].phase[j][i] = j < d->tones ? d->phase[j] : 0.0;
        }
    }
}

/* Begin runs in lanes that have none. A lane that has nothing to do makes one step of a run over and
   over, of which nobody hears. */
static long begin_runs(march *m, block *b) {
    flags_of_lanes loads;
    column state[SIZE + 1], seen[SEEN + 1], points[NUMBERS + 1], start;
    long idle = 0, broken = 0;
    EVERY(i) {
        idle += !b->live[i];
        broken |= !b->loaded[i];
    }
    const long left = m->runs - b->next_run;
    if (idle == LANES && !left) {
        finish_aside(m, &b->aside);
        return 0;
    }
    if (!broken && !(left && (idle >= IDLE || idle == LANES))) return 1;
    EVERY(i) {
        const long begins = !b->live[i] && b->next_run < m->runs;
        loads[i] = begins || !b->loaded[i];
        if (loads[i]) load_run(m, b, i, begins ? b->next_run : 0);
        if (begins) b->next_run++;
        b->live[i] |= begins;
        b->loaded[i] = 1;
        start[i] = loads[i] ? 0.0 : b->time[i];
    }
    k_prepare(LANES, *b->p, *b->c);
    put_signals(m, b, start, 0, b->x0);
    k_init(LANES, *b->c, *b->x0, *state);
    memcpy(b->x2, state, sizeof(column) * SIZE);
    put_signals(m, b, start, 0, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *seen);
    k_observe(LANES, *b->c, *b->x2, *b->row);
    k_points(LANES, *b->c, *state, *points);
    EVERY(i) if (loads[i]) {
        b->fresh[i] = 1;
        for (long k = 0; k < SIZE; k++) b->state[k][i] = state[k][i];
        for (long k = 0; k < SEEN; k++) b->seen[k][i] = seen[k][i];
        for (long k = 0; k < JUDGED; k++) b->low[k][i] = b->high[k][i] = seen[k][i];
        for (long k = 0; k < NUMBERS; k++) b->points[k][i] = b->earlier_points[k][i] = points[k][i];
        double *row = m->rows + b->run[i] * m->samples * OUTPUTS;
        for (long k = 0; k < OUTPUTS && b->live[i]; k++) row[k] = b->row[k][i];
        if (b->live[i]) record_piece(m, b, i, -1.0, 0.0, 0.0, b->one, b->state);
    }
    begin_totals(b, b->row, loads);
    scale_ranges(b);
    end_runs(m, b);
    return 1;
}

long size_of_block(void) { return sizeof(block); }
double time_of(const block *b) { return (void)b, 0.0; }
long run_of(const block *b) { return b->done; }

/* Go on for some rounds. Returns DONE, PAUSED, or RECORD if the record is full. */
long march_on(march *m, block *b, long begin) {
    if (begin) memset(b, 0, sizeof *b);
    for (long round = 0; round < m->rounds; round++) {
        flags_of_lanes taken;
        if (m->recording && m->recorded + 3 * LANES > m->capacity) return RECORD;
        if (!begin_runs(m, b)) return DONE;
        find_segments(m, b);
        plan_lengths(m, b);
        EVERY(i) b->fresh[i] = 0;
        resolve_lengths(m, b);
        try_steps(m, b);
        judge_steps(m, b, taken);
        accept_steps(m, b, taken);
    }
    return PAUSED;
}
