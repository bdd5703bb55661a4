/* The march with an error control in every step: each is as short as the most demanding run needs
   it. What it does is said in martensite/simulate/adaptive.py, which is the same march on floats.

   Before this text stand martensite/simulate/ledger.c with what it asks for, the kernels k_solve
   (or k_rosenbrock if the ORDER of a step is 4, else 2), k_ripple and k_points, and: PLACES (the
   drive of each known heat); of each point its START
   among the numbers of all and its SIZES, the fraction that it is part of (PARTS) and WEIGHTS; and
   PLACES_OF_RATES in the state. SAFETY and other numbers are those of adaptive.py, of the same names. */

#define PART (ORDER == 4 ? 1.0 : 1.0 / 3.0)
#define CHECKED (ORDER == 4 && b->at_edge)

static const long places[HEATED + 1] = PLACES;
static const long parts[POINTS + 1] = PARTS;
static const double weights[POINTS + 1] = WEIGHTS;
static const long rates[RATES + 1] = PLACES_OF_RATES;
static const long start_of[POINTS + 1] = START;
static const long size_of_point[POINTS + 1] = SIZES;

/* ------------------------------------------------------------------ lengths of steps */

static double reach_end(double length, double end) {
    if (length >= (1.0 - STEP_TOLERANCE) * end) return end;
    return length > 0.6 * end ? 0.5 * end : length;
}

/* a length to the next kink of a law, if all goes on as in the last half step */
static double before_kink(const march *m, const block *b, double length) {
    const double least = KINK_MARGIN * length > m->shortest ? KINK_MARGIN * length : m->shortest;
    if (LANES > 1) return length; /* many runs have kinks all the time */
    for (long place = 0; place < POINTS; place++)
        for (long k = start_of[place] + 4; k < start_of[place] + size_of_point[place]; k++) {
            const double now = b->points[k][0], fallen = b->earlier_points[k][0] - now;
            if (!(now > LEAST_FALL && fallen > 0.0)) continue;
            const double there = SHORT * now / fallen * b->last_half;
            length = least < there && there < length ? there : length;
        }
    return length;
}

/* a length that no signal which prescribes a state makes too long */
static double allowed_length(const march *m, const block *b, double length) {
    double end = m->duration - b->time;
    length = length < end ? length : end;
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            const drive *d = drives_of(m, b, set) + i;
            if (widths[i] > 1) continue;
            if (d->fastest > 0.0 && PRESCRIBED / d->fastest < length)
                length = PRESCRIBED / d->fastest;
            long count;
            const double far = b->time + (1.0 + STEP_TOLERANCE) * length;
            const double edge = first_edge(d, b->time + SHORTEST * m->duration, far, b->cursor[set][i], &count);
            if (count && edge - b->time < end) end = edge - b->time;
        }
    return reach_end(length, end);
}

/* a shorter length: to the first edge of a drive that heats, or what resolves its tones */
static double to_edge(const march *m, const block *b, double length) {
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            const drive *d = drives_of(m, b, set) + i;
            if (widths[i] == 1) continue;
            long count;
            const double far = b->time + (1.0 - STEP_TOLERANCE) * length;
            const double edge = first_edge(d, b->time + SHORTEST * m->duration, far, b->cursor[set][i], &count);
            if (count) length = edge - b->time;
            if (d->fastest > 0.0 && SWING / d->fastest < length) length = SWING / d->fastest;
        }
    return length;
}

/* what they bring in both halves of a step, and the largest lapse */
static double bring_halves(const march *m, block *b, double length) {
    const double middle = b->time + 0.5 * length, end = b->time + length;
    double lapse = 0.0;
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            const drive *d = drives_of(m, b, set) + i;
            const long near = b->cursor[set][i];
            moments *one = b->one[set] + i, *two = b->two[set] + i;
            if (widths[i] == 1) {
                one->mean = value_at(d, middle, near, 1);
                two->mean = value_at(d, end, near, 1);
                continue;
            }
            tone_angles first, second;
            turn_angles(d, &b->angles[set][i], length, &first, &second);
            *one = moments_of(d, b->time, middle, near, &first);
            *two = moments_of(d, middle, end, near, &second);
            lapse = one->lapse > lapse ? one->lapse : lapse;
            lapse = two->lapse > lapse ? two->lapse : lapse;
        }
    return lapse;
}

/* the least that counts as a difference of the first judged output, over all runs */
static double heat_scale(const block *b) {
    double least = HUGE_VAL;
    if (!JUDGED) return 1.0;
    LIVE(i) least = b->scale[0][i] < least ? b->scale[0][i] : least;
    return least;
}

/* a length over which the mean of no drive leaves out too much, and what the halves bring; in
   parts the last one before an edge is split */
static void resolve_length(const march *m, block *b) {
    double length = b->length;
    long whole = 0;
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            if (widths[i] == 1) continue;
            long count;
            const drive *d = drives_of(m, b, set) + i;
            const double far = b->time + (1.0 + STEP_TOLERANCE) * length;
            const double edge = first_edge(d, b->time + SHORTEST * m->duration, far, b->cursor[set][i], &count);
            if (count && count <= FEW) length = reach_end(length, edge - b->time);
            whole |= count && count <= FEW && length >= edge - b->time;
        }
    if (m->parted && whole && !b->split) {
        length *= 0.5;
        b->split = 1;
    }
    for (;;) {
        b->lapse = bring_halves(m, b, length);
        b->length = length;
        if (!(b->lapse > 0.0) || b->power * b->lapse <= m->tolerance * heat_scale(b)) return;
        const double shorter = to_edge(m, b, length);
        if (!(shorter < length)) return;
        length = shorter;
    }
}

static double root_of_error(double error) {
    return ORDER == 4 ? sqrt(sqrt(error)) : cbrt(error);
}

/* by what the length of a step is to be changed for the tolerance */
static double change_of(double error) {
    return SAFETY / root_of_error(error > 1e-9 ? error : 1e-9);
}

/* ------------------------------------------------------------------ inputs of the kernels */

static void join(const moments *one, const moments *two, double length, moments *whole) {
    const double per = 1.5 / length;
    for (long i = 0; i < DRIVES; i++) {
        if (widths[i] == 1) {
            whole[i].mean = two[i].mean;
            continue;
        }
        whole[i].mean = 0.5 * (one[i].mean + two[i].mean);
        whole[i].square = 0.5 * (one[i].square + two[i].square);
        whole[i].low = one[i].low < two[i].low ? one[i].low : two[i].low;
        whole[i].high = one[i].high > two[i].high ? one[i].high : two[i].high;
        whole[i].lapse = 0.0;
        whole[i].slope = per * (two[i].mean - one[i].mean) + 0.125 * (one[i].slope + two[i].slope);
        whole[i].square_slope = per * (two[i].square - one[i].square) +
                                0.125 * (one[i].square_slope + two[i].square_slope);
    }
}

/* ------------------------------------------------------------------ a step */

static void begin_runs(march *m, block *b, long run) {
    begin_block(m, b, run);
    begin_ledger(m, b);
    k_points(LANES, *b->c, *b->state, *b->points);
    memcpy(b->earlier_points, b->points, sizeof(column) * NUMBERS);
}

/* whether a signal that prescribes a state jumps here */
static int is_jump(const march *m, const block *b) {
    column after[DRIVES + 1], before[DRIVES + 1];
    int jumps = 0;
    put_signals(m, b, b->time, 0, after);
    put_signals(m, b, b->time, 1, before);
    for (long k = 0; k < DRIVES; k++)
        if (widths[k] == 1) LIVE(i) jumps |= after[k][i] != before[k][i];
    return jumps;
}

static void begin_step(const march *m, block *b) {
    move_cursors(m, b);
    for (long set = 0; set < SETS; set++)
        for (long k = 0; k < DRIVES; k++)
            if (widths[k] > 1) b->angles[set][k] = angles_at(drives_of(m, b, set) + k, b->time);
    const double allowed = allowed_length(m, b, b->next);
    b->leaps = FOLLOWS && is_jump(m, b);
    b->length = b->leaps ? LEAP * allowed : before_kink(m, b, allowed);
    b->grows = MOST_CHANGE;
    b->planned = b->length < allowed ? allowed : 0.0;
}

#if ORDER == 4
/* one step where laws give rates: its end, its middle, and its end to a lower order */
static void solve_step(block *b, const moments (*whole)[DRIVES + 1]) {
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(whole, 0, b->length, b->x0 + SIZE);
    k_rosenbrock(LANES, *b->c, *b->x0, *b->ends);
    memcpy(b->full, b->ends, sizeof(column) * SIZE);
    memcpy(b->half, b->ends + SIZE, sizeof(column) * SIZE);
    memcpy(b->whole, b->ends + 2 * SIZE, sizeof(column) * SIZE);
}
#else
/* a step in two halves, and the same as a whole */
static void solve_step(block *b, const moments (*whole)[DRIVES + 1]) {
    const double gap = 0.5 * (b->last_half + 0.5 * b->length);
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, b->owed, 0.5 * b->length, b->x0 + SIZE);
    for (long k = 0; k < RATES; k++)
        EACH(i) b->x0[rates[k]][i] += gap / b->last_half * (b->x0[rates[k]][i] - b->rate[k][i]);
    k_solve(LANES, *b->c, *b->x0, *b->half);
    memcpy(b->x1, b->half, sizeof(column) * SIZE);
    feed(b->two, 0, 0.5 * b->length, b->x1 + SIZE);
    for (long k = 0; k < RATES; k++)
        EACH(i) b->x1[rates[k]][i] += 0.5 * b->length / gap *
                                      (b->half[rates[k]][i] - b->state[rates[k]][i]);
    k_solve(LANES, *b->c, *b->x1, *b->full);
    feed(whole, b->owed, b->length, b->x0 + SIZE);
    for (long k = 0; k < RATES; k++)
        EACH(i) b->x0[rates[k]][i] = 0.5 * (b->half[rates[k]][i] + b->full[rates[k]][i]);
    k_solve(LANES, *b->c, *b->x0, *b->whole);
}
#endif

/* Behind an edge of a drive rates may die out within a part of a step, which no error estimate of
   that step sees: a step of half its length is compared with its middle, and replaces it. */
static void check_middle(const march *m, block *b) {
#if ORDER == 4
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, 0, 0.5 * b->length, b->x0 + SIZE);
    k_rosenbrock(LANES, *b->c, *b->x0, *b->ends);
    memcpy(b->half, b->ends, sizeof(column) * SIZE);
    memcpy(b->doubted, b->middle, sizeof(column) * SEEN);
    judge_at(m, b, b->half, b->time + 0.5 * b->length, 0, b->middle);
#endif
}

/* what the means of the drives leave out in each half */
static void find_ripple(block *b) {
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, b->owed, 0.5 * b->length, b->x0 + SIZE);
    k_ripple(LANES, *b->c, *b->x0, *b->ripple_half);
    memcpy(b->x1, b->half, sizeof(column) * SIZE);
    feed(b->two, 0, 0.5 * b->length, b->x1 + SIZE);
    k_ripple(LANES, *b->c, *b->x1, *b->ripple_full);
}

static void try_step(const march *m, block *b) {
    moments whole[SETS][DRIVES + 1];
    resolve_length(m, b);
    for (long set = 0; set < SETS; set++) join(b->one[set], b->two[set], b->length, whole[set]);
    solve_step(b, whole);
    if (b->lapse > 0.0) find_ripple(b);
    k_points(LANES, *b->c, *b->half, *b->points_half);
    k_points(LANES, *b->c, *b->full, *b->points_full);
    const double end = b->time + b->length;
    judge_at(m, b, b->whole, end, 1, b->coarse);
    judge_at(m, b, b->half, b->time + 0.5 * b->length, 0, b->middle);
    judge_at(m, b, b->full, end, 1, b->fine);
    if (CHECKED) check_middle(m, b);
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

/* whether a step misses much of a bend near one of its ends, which its error does not show */
static int hides_bend(const block *b, long at, long i, double share, double allowed) {
    const double ratio = 0.5 * b->length / b->last_half;
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

/* share of a step at which the law at a point of a run turns or bends, if that counts; else 1 */
static double find_kink(const march *m, const block *b, long place, long i, double changed,
                        double most) {
    const long at = start_of[place];
    const column *p = b->earlier_points + at, *q = b->points + at;
    const column *a = b->points_half + at, *z = b->points_full + at;
    const double e = p[0][i] - p[1][i] * PER_STRESS, f = q[0][i] - q[1][i] * PER_STRESS;
    const double g = a[0][i] - a[1][i] * PER_STRESS, h = z[0][i] - z[1][i] * PER_STRESS;
    const double bend = (h - g) - (g - f), rise = h - f;
    double first = 1.0;
    if (fabs(rise) < 2.0 * fabs(bend)) {
        const double top = g - rise * rise / (8.0 * bend), share = 0.5 - 0.25 * rise / bend;
        const double moved = fabs(f - e) + fabs(g - f) + fabs(h - g);
        double apart = fabs(top - f);
        apart = fabs(top - g) < apart ? fabs(top - g) : apart;
        apart = fabs(top - h) < apart ? fabs(top - h) : apart;
        if (BESIDE < share && share < 1.0 - BESIDE && changed * apart > most * moved) first = share;
    }
    const double ratio = 0.5 * b->length / b->last_half;
    for (long k = 4; k < size_of_point[place]; k++) {
        const double ahead = ratio * (p[k][i] - q[k][i]);
        const double share = find_fall(ahead, q[k][i], a[k][i], z[k][i]);
        const int seen = b->error[i] > 1.0 && BESIDE < share && share < 1.0 - BESIDE;
        if (share < first && (seen || hides_bend(b, at, i, share, HIDDEN / TURN * most))) first = share;
    }
    return first;
}

/* share of a step at which a number turns that may pass 0 there and nowhere else; else 1 */
static double find_dip(double first, double middle, double last) {
    if (!(first > LEAST_FALL && middle > LEAST_FALL && last > LEAST_FALL)) return 1.0;
    const double bend = (last - middle) - (middle - first), rise = last - first;
    if (!(fabs(rise) < 2.0 * bend)) return 1.0;
    const double low = middle - rise * rise / (8.0 * bend), least = first < last ? first : last;
    return low + low < (middle < least ? middle : least) ? 0.5 - 0.25 * rise / bend : 1.0;
}

static double find_kinks(const march *m, const block *b) {
    double first = 1.0;
    for (long place = 0; place < POINTS; place++) {
        const long at = start_of[place];
        for (long k = at + 4; k < at + size_of_point[place]; k++) LIVE(i) {
            const double dip = find_dip(b->points[k][i], b->points_half[k][i], b->points_full[k][i]);
            if (BESIDE < dip && dip < 1.0 - BESIDE && dip < first) first = dip;
        }
        const double share = TURN * m->tolerance / weights[place];
        column changed, most;
        long any = 0;
        EACH(i) {
            changed[i] = 0.0;
            for (long k = at + 2; k < at + 4; k++) {
                const double sum = fabs(b->points[k][i] - b->earlier_points[k][i]) +
                                   fabs(b->points_half[k][i] - b->points[k][i]) +
                                   fabs(b->points_full[k][i] - b->points_half[k][i]);
                changed[i] = sum > changed[i] ? sum : changed[i];
            }
            most[i] = share * b->scale[parts[place]][i];
            any |= changed[i] > most[i];
        }
        if (!any) continue;
        LIVE(i) if (changed[i] > most[i]) {
            const double kink = find_kink(m, b, place, i, changed[i], most[i]);
            first = kink < first ? kink : first;
        }
    }
    return first;
}

/* errors of all runs as shares of the tolerance: the largest, and whether all are solved */
static double judge_errors(const march *m, block *b, column ripple, column residual) {
    const double per = 1.0 / m->tolerance;
    double worst = 0.0;
    column finite;
    EACH(i) {
        finite[i] = 0.0;
        for (long k = 0; k < SEEN; k++) finite[i] += 0.0 * b->fine[k][i] + 0.0 * b->coarse[k][i];
        const double a = b->whole[SIZE][i], c = b->half[SIZE][i], e = b->full[SIZE][i];
        const double ac = a <= c ? c : a;
        residual[i] = ac <= e ? e : ac;
        ripple[i] = 0.0;
        b->error[i] = 0.0;
    }
    if (b->lapse > 0.0) {
        double most = 0.0;
        EACH(i) ripple[i] = b->ripple_half[0][i] > b->ripple_full[0][i] ? b->ripple_half[0][i]
                                                                       : b->ripple_full[0][i];
        LIVE(i) most = ripple[i] > most ? ripple[i] : most;
        b->power = most / b->lapse;
    }
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double apart = PART * fabs(b->fine[k][i] - b->coarse[k][i]);
            const double high = b->fine[k][i] - b->low[k][i], low = b->high[k][i] - b->fine[k][i];
            double scale = b->scale[k][i] > high ? b->scale[k][i] : high;
            scale = scale > low ? scale : low;
            const double own = (k ? apart : apart > ripple[i] ? apart : ripple[i]) / scale * per;
            b->error[i] = own > b->error[i] ? own : b->error[i];
        }
    for (long k = 0; k < (CHECKED ? JUDGED : 0); k++)
        EACH(i) {
            const double own = fabs(b->middle[k][i] - b->doubted[k][i]) / b->scale[k][i] * per;
            b->error[i] = own > b->error[i] ? own : b->error[i];
        }
    /* Where a signal prescribes a state the ends of a step are right however long it is: a part of the bend counts. */
    for (long k = 0; k < (FOLLOWS && !b->leaps ? JUDGED : 0); k++)
        EACH(i) {
            const double bend = fabs(b->onset[k][i] - 2.0 * b->middle[k][i] + b->fine[k][i]);
            const double own = BEND * bend / b->scale[k][i] * per;
            b->error[i] = own > b->error[i] ? own : b->error[i];
        }
    LIVE(i) {
        if (!(finite[i] == 0.0 && residual[i] <= SOLVED)) b->error[i] = HUGE_VAL;
        worst = b->error[i] > worst ? b->error[i] : worst;
    }
    return worst;
}

/* whether the step is taken, or how long the next trial is */
static int judge_step(march *m, block *b) {
    const double shortest = m->shortest, length = b->length;
    column ripple, residual;
    double worst = judge_errors(m, b, ripple, residual);
    if (length <= shortest)
        LIVE(i) if (b->error[i] == HUGE_VAL) {
            b->status[i] = residual[i] > SOLVED ? UNSOLVED : NOT_FINITE;
            b->error[i] = 0.0;
        }
    const int solved = worst < HUGE_VAL, good = worst <= 1.0, last = length <= shortest;
    const double kink = solved && !last ? find_kinks(m, b) : 1.0;
    if (last || (good && kink == 1.0)) {
        LIVE(i) {
            b->ripple[i] = ripple[i] > b->ripple[i] ? ripple[i] : b->ripple[i];
            b->residual[i] = residual[i] > b->residual[i] ? residual[i] : b->residual[i];
            if (b->error[i] > 1.0) b->residual[i] += m->tolerance * b->error[i]; /* no step is shorter */
        }
        if (last && !good) worst = 1.0;
        double change = change_of(worst);
        const double cube = length * length * length;
        const double rough = (worst > 1e-9 ? worst : 1e-9) / (ORDER == 4 ? cube * length : cube);
        if (b->rough > 0.0 && b->rough < rough) change *= root_of_error(b->rough / rough);
        const double grown = length * (change < LEAST_CHANGE ? LEAST_CHANGE :
                                       change > b->grows ? b->grows : change);
        if (b->at_kink) b->after_kink = MOST_CHANGE * length;
        b->at_kink = b->planned > 0.0;
        const double most = !b->at_kink || b->after_kink > grown ? b->after_kink : grown;
        b->rough = b->at_kink ? 0.0 : rough;
        b->next = grown > b->planned ? grown : b->planned;
        if (b->at_kink && most < b->next) b->next = most;
        b->next = b->next > shortest ? b->next : shortest;
        return 1;
    }
    b->rejected++;
    double shorter = solved ? length : 0.25 * length;
    if (good)
        b->planned = length > b->planned ? length : b->planned;
    else
        b->grows = 1.0;
    if (kink < 1.0) {
        shorter = kink * length;
    } else if (solved) {
        const double change = change_of(worst);
        shorter = length * (change < LEAST_CHANGE ? LEAST_CHANGE : change > SAFETY ? SAFETY : change);
        if (b->power * b->lapse > m->tolerance * heat_scale(b)) {
            const double edge = to_edge(m, b, length);
            shorter = edge < shorter ? edge : shorter;
        }
    }
    b->length = shorter > 0.5 * shortest ? shorter : 0.5 * shortest;
    return 0;
}

/* ------------------------------------------------------------------ samples */

/* whether a number of the state is more than where a solve begins to look */
static long is_judged_state(long k) {
    for (long i = 0; i < RATES; i++)
        if (rates[i] == k) return 0;
    return 1;
}

/* whether the polynomial through the last five points is good enough in the step */
static int is_smooth(const march *m, const block *b, double *per) {
    if (!b->known || b->lapse > 0.0) return 0;
    const double half = 0.5 * b->length;
    const double t[5] = {b->node_time[0], b->node_time[1], b->time, b->time + half,
                         b->time + b->length};
    const double reached = CUBIC * half * half * half * (t[4] - t[1]);
    for (long j = 0; j < 5; j++) {
        double product = 1.0;
        for (long k = 0; k < 5; k++) product *= k == j ? 1.0 : t[j] - t[k];
        per[j] = 1.0 / product;
    }
    long rough = 0;
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double fourth = per[0] * b->node_seen[0][k][i] + per[1] * b->node_seen[1][k][i] +
                                  per[2] * b->seen[k][i] + per[3] * b->middle[k][i] +
                                  per[4] * b->fine[k][i];
            rough |= b->live[i] &&
                     !(reached * fabs(fourth) <= BETWEEN * m->tolerance * b->scale[k][i]);
        }
    return !rough;
}

/* states on it at a time, unless it overshoots what it goes through; `per` are the inverse
   denominators of its weights */
static int interpolate(const block *b, double time, const double *per, column *x) {
    long over = 0;
    const double t0 = time - b->node_time[0], t1 = time - b->node_time[1], t2 = time - b->time;
    const double t3 = t2 - 0.5 * b->length, t4 = t2 - b->length, low = t0 * t1, high = t3 * t4;
    const double w[5] = {per[0] * t1 * t2 * high, per[1] * t0 * t2 * high, per[2] * low * high,
                         per[3] * low * t2 * t4, per[4] * low * t2 * t3};
    for (long k = 0; k < SIZE; k++) {
        const long counts = is_judged_state(k);
        EACH(i) {
            const double at[5] = {b->node_state[0][k][i], b->node_state[1][k][i], b->state[k][i],
                                  b->half[k][i], b->full[k][i]};
            double least = at[0], most = at[0], sum = w[0] * at[0];
            for (long j = 1; j < 5; j++) {
                sum += w[j] * at[j];
                least = at[j] < least ? at[j] : least;
                most = at[j] > most ? at[j] : most;
            }
            const double hair = ROUNDING * (fabs(least) + fabs(most));
            over |= counts && b->live[i] && !(least - hair <= sum && sum <= most + hair);
            x[k][i] = sum < least ? least : sum > most ? most : sum;
        }
    }
    return !over;
}

/* states at a time after a step from the start or the middle of the one taken */
static void step_aside(const march *m, block *b, double time, column *x) {
    const double middle = b->time + 0.5 * b->length;
    const int late = ORDER == 2 && time >= middle;
    const double begin = late ? middle : b->time;
    memcpy(x, late ? b->half : b->state, sizeof(column) * SIZE);
    if (!(time - begin > STEP_TOLERANCE * b->length)) return;
    moments found[SETS][DRIVES + 1];
    bring(m, b, begin, time, found);
    feed(found, late ? 0 : b->owed, time - begin, x + SIZE);
#if ORDER == 4
    k_rosenbrock(LANES, *b->c, *x, *b->ends);
    memcpy(x, b->ends, sizeof(column) * SIZE);
#else
    k_solve(LANES, *b->c, *x, *b->whole);
    /* where that is not solved, a straight line between states that were */
    const double share = (time - begin) / (0.5 * b->length);
    const column *from = late ? b->half : b->state, *to = late ? b->full : b->half;
    for (long k = 0; k < SIZE; k++)
        EACH(i) x[k][i] = b->whole[SIZE][i] <= SOLVED ? b->whole[k][i]
                                                     : from[k][i] + share * (to[k][i] - from[k][i]);
#endif
}

/* outputs at the samples within the step that was taken */
static void keep_samples(march *m, block *b, double end) {
    const double hair = STEP_TOLERANCE * b->length;
    double per[5];
    int smooth = -1;
    for (; b->sample < m->samples && m->times[b->sample] <= end + hair;) {
        const double time = m->times[b->sample];
        if (time >= end - hair) {
            memcpy(b->x2, b->full, sizeof(column) * SIZE);
        } else {
            if (smooth < 0) smooth = is_smooth(m, b, per);
            if (!smooth || !interpolate(b, time, per, b->x2)) step_aside(m, b, time, b->x2);
        }
        keep_rows(m, b, time);
    }
}

/* ------------------------------------------------------------------ the way through time */

static void accept_step(march *m, block *b) {
    const double length = b->length;
    keep_ledger(m, b);
    double end = b->time + length;
    if (m->duration - end < SHORTEST * m->duration) end = m->duration;
    LIVE(i) if (b->status[i] != OK) { /* it has no solution here, and ends where it began */
        tell(m, b, i);
        b->live[i] = 0;
    }
    keep_samples(m, b, end);
    const double own = ORDER == 4 ? length : 0.5 * length;
    b->steps += ORDER == 4 ? 1 : 2;
    b->longest = own > b->longest ? own : b->longest;
    record_piece(m, b, 1.0, b->time, b->time + 0.5 * length, b->one[0], b->half);
    record_piece(m, b, 2.0, b->time + 0.5 * length, end, b->two[0], b->full);
    long long taken[LANES];
    EACH(i) {
        taken[i] = b->live[i];
        for (long k = 0; k < ENVELOPE; k++) taken[i] &= is_inside(b, b->fine, k, i);
    }
    add_totals(m, b, taken);
    if (b->at_edge && !b->leaps) b->after_edge = MOST_CHANGE * length;
    b->at_edge = 0;
    for (long set = 0; set < SETS; set++)
        for (long k = 0; k < DRIVES; k++) {
            long count;
            const drive *d = drives_of(m, b, set) + k;
            first_edge(d, end - STEP_TOLERANCE * length, end + STEP_TOLERANCE * length, b->cursor[set][k], &count);
            b->at_edge |= count > 0;
        }
    if (b->at_edge && b->after_edge < b->next) b->next = b->after_edge;
    if (b->at_edge) b->rough = 0.0;
    if (b->at_edge) b->split = 0;
    b->known = !b->at_edge && !(b->lapse > 0.0);
    b->last_half = 0.5 * length;
    b->node_time[0] = b->time;
    b->node_time[1] = b->time + 0.5 * length;
    memcpy(b->node_state[0], b->state, sizeof(column) * SIZE);
    memcpy(b->node_state[1], b->half, sizeof(column) * SIZE);
    memcpy(b->node_seen[0], b->seen, sizeof(column) * JUDGED);
    memcpy(b->node_seen[1], b->middle, sizeof(column) * JUDGED);
    memcpy(b->earlier_points, b->points_half, sizeof(column) * NUMBERS);
    memcpy(b->points, b->points_full, sizeof(column) * NUMBERS);
    for (long k = 0; k < HEATED; k++)
        EACH(i) b->owed[places[k]][i] = ORDER == 2 ? (b->fine[JUDGED + ENVELOPE + k][i] -
                                                     b->coarse[JUDGED + ENVELOPE + k][i]) * PART : 0.0;
    for (long k = 0; k < RATES; k++) memcpy(b->rate[k], b->half[rates[k]], sizeof(column));
    memcpy(b->state, b->full, sizeof(column) * SIZE);
    b->time = end;
    see(m, b, b->fine);
    end_runs(m, b);
}

/* Go on for some rounds. Returns DONE, PAUSED, SIGNALS if drives must be known further, or RECORD
   if the record is full. */
long march_on(march *m, block *b, long begin) {
    if (begin) b->begun = 0;
    for (long round = 0; round < m->rounds; round++) {
        while (!any_live(b)) {
            const long next = b->begun ? b->first_run + LANES : 0;
            if (next >= m->runs) return DONE;
            if (is_full(m)) return RECORD;
            begin_runs(m, b, next);
            begin_step(m, b);
        }
        if (!known_until(m, b, b->time + (1.0 + 2.0 * STEP_TOLERANCE) * b->length)) return SIGNALS;
        if (is_full(m)) return RECORD;
        try_step(m, b);
        if (!judge_step(m, b)) continue;
        accept_step(m, b);
        begin_step(m, b);
    }
    return PAUSED;
}
