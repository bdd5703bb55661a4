/* Drives of lanes, and their moments in steps: reader.c for all lanes at once. Before this text stands marching.c. */

/* the value of a drive of a lane, at a time or just `before` it */
INLINE double value_of(const march *m, const block *b, long k, long i, double time, int before) {
    return value_at(drive_of(m, b->now + k, k, i), time, b->now[k].cursor[i], before);
}

#define MOST_TURNS 64

/* series or quotient of sinc, see reader.c */
INLINE void sincs(const column x, column found) {
    flags_of_lanes far;
    EACH(i) {
        const double z = x[i] * x[i];
        found[i] = 1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0) *
                   (1.0 - z * (1.0 / 42.0) * (1.0 - z * (1.0 / 72.0))));
    }
    EACH(i) far[i] = !(fabs(x[i]) < SERIES);
    SOME(i, bits_of(far)) found[i] = sinc(x[i]);
}

INLINE void leanings(const column x, column found) {
    flags_of_lanes far;
    EACH(i) {
        const double z = x[i] * x[i];
        found[i] = x[i] * (1.0 / 3.0 - z * (1.0 / 30.0 - z * (1.0 / 840.0 - z * (1.0 / 45360.0))));
    }
    EACH(i) far[i] = !(fabs(x[i]) < SERIES);
    SOME(i, bits_of(far)) found[i] = leaning(x[i]);
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
/* angles of tones in the middle of both halves of a step and at its end, turned from those at its start */
static void turn(const drives_of_lanes *d, long j, const column length, column *one, column *two, column *end) {
    column x, s, c;
    EACH(i) x[i] = 0.25 * d->speed[j][i] * length[i];
    sincs(x, s);
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
        end[0][i] = two[0][i] * c[i] - two[1][i] * s[i];
        end[1][i] = two[1][i] * c[i] + two[0][i] * s[i];
    }
}

/* half of the intervals as angles of tones, and functions of them, alone and, for mean squares, of pairs */
typedef struct {
    column reach[TONES], share[TONES], lean[TONES], near[TONES][TONES], far[TONES][TONES];
} reaches;

static void find_reaches(const drives_of_lanes *d, const column half, long squares, reaches *r) {
    for (long j = 0; j < TONES; j++) {
        EACH(i) r->reach[j][i] = d->speed[j][i] * half[i];
        sincs(r->reach[j], r->share[j]);
        leanings(r->reach[j], r->lean[j]);
        for (long l = 0; l <= j && squares; l++) {
            column apart, both;
            EACH(i) {
                apart[i] = r->reach[j][i] - r->reach[l][i];
                both[i] = r->reach[j][i] + r->reach[l][i];
                r->near[j][l][i] = 1.0;
            }
            if (l < j) sincs(apart, r->near[j][l]);
            sincs(both, r->far[j][l]);
        }
    }
}

/* what tones add to levels that are constant; `at` are cosines and sines in the middle */
static void add_tones(const drives_of_lanes *d, const column (*at)[2], const reaches *r,
                      const column half, long squares, column *m) {
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
        for (long l = 0; l <= j && squares; l++) {
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

/* whether mean squares count in all steps: steps of order five do without */
INLINE long needs_squares(const march *m) { return ORDER != 5 || m->recording || m->totals; }

/* what a drive that heats brings in both halves of the steps, for lanes that ask */
static void bring_halves(const march *m, block *b, long k, const flags_of_lanes asked, long squares) {
    drives_of_lanes *d = b->now + k;
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
    EACH(i) {
        plain[i] &= asked[i];
        d->ready[i] = asked[i] ? plain[i] : d->ready[i];
    }
    if (any(plain)) {
        of_parabola(d, first, half, one);
        of_parabola(d, last, half, two);
#if TONES > 0
        column at_one[TONES][2], at_two[TONES][2];
        reaches r;
        find_reaches(d, half, squares, &r);
        for (long j = 0; j < TONES; j++) {
            column at_end[2];
            turn(d, j, b->length, at_one[j], at_two[j], at_end);
            BLEND(d->last_cosine[j], plain, at_end[0]);
            BLEND(d->last_sine[j], plain, at_end[1]);
        }
        add_tones(d, at_one, &r, half, squares, one);
        add_tones(d, at_two, &r, half, squares, two);
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
            bring_halves(m, b, k, asked, needs_squares(m));
            continue;
        }
        EVERY(i) if (asked[i]) {
            b->one[k][MEAN][i] = value_of(m, b, k, i, b->time[i] + 0.5 * b->length[i], 1);
            b->two[k][MEAN][i] = value_of(m, b, k, i, b->time[i] + b->length[i], 1);
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
        EVERY(i) x[k][i] = value_of(m, b, k, i, time[i], before);
}
/* the segment of a drive at a time */
static void find_segment(const march *m, drives_of_lanes *d, long k, long i, double time) {
    const drive *one = drive_of(m, d, k, i);
    const long now = segment_at(one, time, d->cursor[i]);
    d->cursor[i] = now;
    d->start[i] = one->start[now];
    d->level[i] = one->level[now];
    d->slope[i] = one->slope[now];
    d->bend[i] = one->bend[now];
    d->following[i] = now + 1 < one->count ? one->start[now + 1] : HUGE_VAL;
}

/* angles of tones at the start of steps: those at the end of the last ones, or anew */
static void find_angles(const block *b, drives_of_lanes *d) {
    flags_of_lanes turned, anew;
    EACH(i) {
        turned[i] = b->fresh[i] & d->ready[i] & (d->turns[i] < MOST_TURNS);
        anew[i] = b->fresh[i] & !turned[i];
        d->turns[i] = anew[i] ? 0 : d->turns[i] + turned[i];
    }
    const int some = any(anew);
    for (long j = 0; j < TONES; j++) {
        column cosine, sine;
        BLEND(d->cosine[j], turned, d->last_cosine[j]);
        BLEND(d->sine[j], turned, d->last_sine[j]);
        if (!some) continue;
        /* in loops of their own: no function of vectors gives both */
        EACH(i) cosine[i] = cos(d->speed[j][i] * b->time[i] + d->phase[j][i]);
        EACH(i) sine[i] = sin(d->speed[j][i] * b->time[i] + d->phase[j][i]);
        BLEND(d->cosine[j], anew, cosine);
        BLEND(d->sine[j], anew, sine);
    }
}

/* where drives are at the start of steps */
static void find_segments(const march *m, block *b) {
    if (!any(b->fresh)) return;
    for (long k = 0; k < DRIVES; k++) {
        drives_of_lanes *d = b->now + k;
        EVERY(i) if (b->fresh[i]) find_segment(m, d, k, i, b->time[i]);
        if (TONES > 0 && widths[k] > 1) find_angles(b, d);
    }
}
