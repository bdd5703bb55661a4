/* Steps of order five of laws with surfaces: their lengths, kinks and states within, as in adaptive.py.

   Before this text stands runs.c. The kernel k_surface leaves six states in `ends`: at the end, in the middle, at the
   end to order four, at the start in the process of the step, and the changes by the slopes at both ends. The PATH of
   temperature, stress and martensite fraction follows (start, middle, end, and changes by both slopes), then the
   residual and the decay. The kernel k_events gives the numbers that fall to 0 at kinks. */

#if ORDER == 5
#define PATH (6 * SIZE)
#define RESIDUAL (6 * SIZE + 15)
#define DECAY (6 * SIZE + 16)
enum { TEMPERATURE, STRESS, FRACTION, ON_PATH };

/* a length at which a step has order five, unless a much longer one is possible, not behind a kink */
static double limit_length(const march *m, const block *b, long i) {
    const double next = b->next[i];
    double most = b->decay[i] > 0.0 ? STIFF / b->decay[i] : HUGE_VAL;
    if (!b->on_surface[i]) return next;
    for (long k = 0; k < DRIVES; k++) {
        const double fastest = drive_of(m, b->now + k, k, i)->fastest;
        if (fastest > 0.0 && b->phase / fastest < most) most = b->phase / fastest;
    }
    return most < next && (b->at_kink[i] || next < BEYOND * most) ? most : next;
}

/* a polynomial on [0, 1] with values at the ends and in the middle, and changes by the slopes at the ends */
INLINE double follow_quartic(double x, double start, double middle, double end, double first, double last) {
    const double square = x * x;
    const double moved = square * (16.0 + x * (16.0 * x - 32.0)) * (middle - start) +
                         square * (x * (14.0 - 8.0 * x) - 5.0) * (end - start);
    return start + (moved + x * (1.0 + x * (x * (5.0 - 2.0 * x) - 4.0)) * first +
                    square * (1.0 + x * (2.0 * x - 3.0)) * last);
}

/* a number of the path at a share of each step */
static void follow_path(const block *b, const column share, long k, column at) {
    const column *p = b->ends + PATH + k;
    const column *q = p + ON_PATH, *r = q + ON_PATH, *first = r + ON_PATH, *last = first + ON_PATH;
    EACH(i) at[i] = follow_quartic(share[i], p[0][i], q[0][i], r[0][i], first[0][i], last[0][i]);
}

/* the numbers that fall to 0 at kinks, at the temperature and stress in x2 */
static void ask_events(block *b, column *found) {
    memcpy(b->x2, b->ends + 3 * SIZE, sizeof(column) * SIZE);
    k_events(LANES, *b->c, *b->x2, *found);
}

/* the same at a share of each step */
static void ask_events_at(block *b, const column share, column *found) {
    follow_path(b, share, TEMPERATURE, b->x2[SIZE]);
    follow_path(b, share, STRESS, b->x2[SIZE + 1]);
    ask_events(b, found);
}

/* the same at the start (0), in the middle (1) or at the end (2) of each step */
static void ask_events_of(block *b, long place, column *found) {
    memcpy(b->x2 + SIZE, b->ends + PATH + ON_PATH * place + TEMPERATURE, 2 * sizeof(column));
    ask_events(b, found);
}

/* an interval in which a function falls to 0 or below, and the next place to look at */
typedef struct {
    double low, high, above, below, share;
    long side;
} bracket;

/* shrink it by the rule of Illinois */
static void shrink(bracket *r, double value) {
    const long down = value <= 0.0;
    if (down) {
        r->high = r->share;
        r->below = value;
        r->above *= r->side == 1 ? 0.5 : 1.0;
    } else {
        r->low = r->share;
        r->above = value;
        r->below *= r->side == 2 ? 0.5 : 1.0;
    }
    r->side = down ? 1 : 2;
    r->share = r->above > r->below ? r->low + (r->high - r->low) * r->above / (r->above - r->below) : r->high;
}

/* share of a step at which the temperature turns */
static double find_turn_of_path(const block *b, long i) {
    const column *p = b->ends + PATH + TEMPERATURE;
    const double middle = p[ON_PATH][i] - p[0][i], end = p[2 * ON_PATH][i] - p[0][i];
    const double first = p[3 * ON_PATH][i], last = p[4 * ON_PATH][i], sign = first < 0.0 ? -1.0 : 1.0;
    const double a = 2.0 * (16.0 * middle - 5.0 * end - 4.0 * first + last);
    const double d = 3.0 * (14.0 * end - 32.0 * middle + 5.0 * first - 3.0 * last);
    const double e = 4.0 * (16.0 * middle - 8.0 * end - 2.0 * first + 2.0 * last);
    bracket r = {0.0, 1.0, sign * first, sign * last, first / (first - last), 0};
    for (long turn = 0; turn < EVENT_TURNS; turn++) {
        const double x = r.share;
        shrink(&r, sign * (first + x * (a + x * (d + x * e))));
    }
    return r.share;
}

/* whether the temperature turns within a step */
INLINE int turns(const block *b, long i) {
    return b->ends[PATH + 3 * ON_PATH][i] * b->ends[PATH + 4 * ON_PATH][i] < 0.0;
}

/* the numbers between, where the temperature turns or in the middle, and at the end of each step */
static void place_events(block *b) {
    flags_of_lanes turning;
    EACH(i) {
        b->between[i] = 0.5;
        turning[i] = b->on_surface[i] & turns(b, i);
    }
    if (any(turning)) {
        SOME(i, bits_of(turning)) b->between[i] = find_turn_of_path(b, i);
        ask_events_at(b, b->between, b->event_between);
    } else {
        ask_events_of(b, 1, b->event_between);
    }
    ask_events_of(b, 2, b->event_end);
    b->begun = 0;
}

/* the numbers at the start of each step, where they count */
static void place_begins(block *b) {
    if (!b->begun) ask_events_of(b, 0, b->event_begin);
    b->begun = 1;
}

/* Cut steps where a process begins or ends, if their error shows it, if they turn behind it, or if they turn before it
   where the line was passed before. */
static void cut_at_events(block *b) {
    bracket r[LANES];
    column share, found[NUMBERS + 1];
    flags_of_lanes asked, may, seen, counts; /* whether a line counts that is passed before the middle */
    long place[LANES];
    EACH(i) {
        asked[i] = may[i] = 0;
        seen[i] = b->error[i] > 1.0;
        counts[i] = seen[i] | turns(b, i);
    }
    for (long k = 0; k < NUMBERS - 4; k++)
        EACH(i) {
            const double between = b->event_between[k][i], end = b->event_end[k][i];
            const long long down = between <= 0.0, up = between > LEAST_FALL, ends = end <= 0.0;
            may[i] |= (down & (counts[i] | !ends)) | (ends & !down & (seen[i] | up));
        }
    EACH(i) may[i] &= b->on_surface[i];
    if (!any(may)) return;
    place_begins(b);
    EACH(i) share[i] = 1.0;
    SOME(i, bits_of(may)) {
        r[i].share = 2.0;
        for (long k = 0; k < NUMBERS - 4; k++) {
            const double begin = b->event_begin[k][i], between = b->event_between[k][i], end = b->event_end[k][i];
            const int late = between > 0.0, inside = begin <= LEAST_FALL;
            if (late ? !(end <= 0.0) || (inside && between <= LEAST_FALL) : inside) continue;
            asked[i] |= late ? inside | seen[i] : counts[i] | (end > 0.0);
            const double low = late ? b->between[i] : 0.0, high = late ? 1.0 : b->between[i];
            const double above = late ? between : begin, below = late ? end : between;
            const double there = low + (high - low) * above / (above - below);
            if (!(there < r[i].share)) continue;
            r[i].low = low;
            r[i].high = high;
            r[i].above = above;
            r[i].below = below;
            r[i].share = there;
            r[i].side = 0;
            place[i] = k;
        }
    }
    if (!any(asked)) return;
    for (long turn = 0; turn < EVENT_TURNS; turn++) {
        SOME(i, bits_of(asked)) share[i] = r[i].share;
        ask_events_at(b, share, found);
        SOME(i, bits_of(asked)) shrink(r + i, found[place[i]][i]);
    }
    SOME(i, bits_of(asked)) {
        const double margin = b->error[i] > 1.0 ? NEAREST : BESIDE;
        if (r[i].share < 1.0 - margin) b->kink[i] = r[i].share;
    }
}

/* whether a process acts before or behind the place where the temperature turns inside its strip; one that waits for
   its interrupted branch has an event, a number between 0 and 1 behind those of the lines */
static long acts_at_turn(const column *start, const column *turn, const column *end, long i, double allowed) {
    long acts = 0;
    if (LINES < NUMBERS - 4 && 0.0 < turn[LINES][i] && turn[LINES][i] < 1.0) return 0;
    for (long k = 0; k < 2; k++)
        if (turn[k][i] <= 0.0 && 0.0 < turn[k + 2][i])
            acts |= larger(start[k][i] - turn[k][i], turn[k][i] - end[k][i]) > allowed;
    return acts;
}

/* cut steps behind the place where their process turns back by more than a fraction, or another begins */
static void cut_at_reversals(block *b, const column allowed) {
    column top;
    flags_of_lanes asked;
    const double *end = b->ends[PATH + 2 * ON_PATH + FRACTION];
    EACH(i) asked[i] = b->on_surface[i] & b->accurate[i] & turns(b, i);
    if (!any(asked)) return;
    place_begins(b);
    follow_path(b, b->between, FRACTION, top);
    SOME(i, bits_of(asked)) {
        const double share = (1.0 + BESIDE) * b->between[i];
        if (!(share < 1.0 - BESIDE)) continue;
        if (fabs(top[i] - end[i]) > allowed[i] ||
            acts_at_turn(b->event_begin, b->event_between, b->event_end, i, allowed[i]))
            b->kink[i] = smaller(share, b->kink[i]);
    }
}

/* slope at the start and curvature of a parabola over a step: through both ends and the middle, or, if early, through
   the point half a step earlier, the start and the middle */
INLINE void fit_step(const block *b, long k, long i, int early, double *slope, double *bend) {
    const double first = b->points[k][i], middle = b->points_half[k][i], last = b->points_full[k][i];
    const double ratio = b->at_edge[i] ? 0.0 : 0.5 * b->length[i] / b->last_half[i], after = middle - first;
    const double before = ratio * (first - b->earlier_points[k][i]), around = 2.0 * (first - 2.0 * middle + last);
    *bend = early ? 4.0 * ratio * (after - before) / (1.0 + ratio) : around;
    *slope = early ? 2.0 * after - 0.5 * *bend : last - first - around;
}

/* cut steps in halves where the temperature turns, if an unseen process acts there; a turn near the start is on the
   parabola of the point half a step earlier */
static void cut_at_touches(block *b, const column allowed) {
    const column *p = b->points + 4, *q = b->points_half + 4, *r = b->points_full + 4;
    column share, turn[NUMBERS + 1];
    flags_of_lanes asked, early;
    EACH(i) asked[i] = b->live[i] & !b->on_surface[i];
    if (!any(asked)) return;
    EACH(i) {
        double slope, bend, earlier, more;
        fit_step(b, 0, i, 0, &slope, &bend);
        fit_step(b, 0, i, 1, &earlier, &more);
        const double x = bend != 0.0 ? -0.5 * slope / bend : 1.0, y = more != 0.0 ? -0.5 * earlier / more : 1.0;
        const long long around = (BESIDE < x) & (x < 1.0 - BESIDE), behind = (BESIDE < y) & (y < 0.5);
        early[i] = !around;
        share[i] = around ? x : y;
        asked[i] &= around | behind;
    }
    if (!any(asked)) return;
    memcpy(b->x2, b->state, sizeof(column) * SIZE);
    for (long k = 0; k < 2; k++)
        EACH(i) {
            double slope, bend;
            fit_step(b, k, i, early[i] != 0, &slope, &bend);
            b->x2[SIZE + k][i] = b->points[k][i] + share[i] * slope + (share[i] * share[i] - 0.5 * REACH) * bend;
        }
    k_events(LANES, *b->c, *b->x2, *turn);
    SOME(i, bits_of(asked)) {
        long touches = acts_at_turn(turn, turn, r, i, allowed[i]);
        for (long k = 0; k < NUMBERS - 4; k++)
            touches |= turn[k][i] <= 0.0 && turn[k][i] < p[k][i] && q[k][i] > LEAST_FALL && r[k][i] > LEAST_FALL;
        if (touches) b->kink[i] = smaller(share[i], b->kink[i]);
    }
}

/* states at times within steps of order five */
static void follow_slopes(const block *b, const column time, const flags_of_lanes within, long all, column *x) {
    column share;
    EACH(i) share[i] = (time[i] - b->time[i]) / b->length[i];
    for (long k = 0; k < SIZE; k++) {
        if (!(all || observed[k])) continue;
        const double *first = b->ends[4 * SIZE + k], *last = b->ends[5 * SIZE + k];
        EACH(i) {
            const double start = b->state[k][i], middle = b->half[k][i], end = b->full[k][i];
            const double there = follow_quartic(share[i], start, middle, end, first[i], last[i]);
            x[k][i] = within[i] ? there : x[k][i];
        }
    }
}
#else
#define RESIDUAL 0
#define limit_length(m, b, i) ((b)->next[i])
#endif
