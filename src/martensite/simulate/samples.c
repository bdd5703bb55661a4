/* Outputs at samples within steps: from a polynomial, or from a step aside. As on floats, a single run tests the
   polynomial in all states. */

#define DEEPEST 2 /* earlier steps that a polynomial may use */
static const long rates[RATES + 1] = PLACES_OF_RATES;

/* whether a number of the state is more than where a solve begins to look */
static long is_judged_state(long k) {
    for (long i = 0; i < RATES; i++)
        if (rates[i] == k) return 0;
    return 1;
}

/* Whether the polynomial through the last five points is good enough in each step, and in the step before; the inverse
   denominators of its weights. Its own last term is small enough, or, where a sixth point is known,
   the one that would come next. */
static void find_smooth(const march *m, const block *b, flags_of_lanes smooth, flags_of_lanes before, column *per) {
    column reached[2], farther[2], from_tail[5], over;
    flags_of_lanes flat[2], flatter[2], resolved;
    EACH(i) {
        const double half = 0.5 * b->length[i], t2 = b->time[i], tail = b->older_time[i];
        const double t[5] = {b->node_time[0][i], b->node_time[1][i], t2, t2 + half, t2 + b->length[i]};
        const double last = t[1] - t[0], cubic = CUBIC * half * half * half, late = CUBIC * last * last * last;
        reached[0][i] = cubic * (t[4] - t[1]);
        reached[1][i] = late * (t[3] - t[0]);
        farther[0][i] = reached[0][i] * (t[4] - t[0]);
        farther[1][i] = reached[1][i] * (t[4] - t[0]);
        for (long j = 0; j < 5; j++) {
            double product = 1.0;
            for (long k = 0; k < 5; k++) product *= k == j ? 1.0 : t[j] - t[k];
            per[j][i] = 1.0 / product;
        }
        over[i] = -1.0;
        for (long j = 0; j < 5; j++) {
            from_tail[j][i] = 1.0 / (t[j] - tail);
            over[i] *= from_tail[j][i];
        }
        flat[0][i] = flatter[0][i] = flat[1][i] = flatter[1][i] = resolved[i] = 1;
    }
    for (long k = 0; k < DRIVES; k++)
        EVERY(i) {
            const double longest = larger(0.5 * b->length[i], b->last_half[i]);
            resolved[i] &= drive_of(m, b->now + k, k, i)->fastest * longest <= TRACED;
        }
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double a = per[0][i] * b->node_seen[0][k][i], c = per[1][i] * b->node_seen[1][k][i];
            const double d = per[2][i] * b->seen[k][i], e = per[3][i] * b->middle[k][i];
            const double f = per[4][i] * b->fine[k][i];
            const double fifth = a * from_tail[0][i] + c * from_tail[1][i] + d * from_tail[2][i] +
                                 e * from_tail[3][i] + f * from_tail[4][i] + over[i] * b->older_seen[k][i];
            const double fourth = a + c + d + e + f, allowed = BETWEEN * m->tolerance * b->scale[k][i];
            for (long j = 0; j < 2; j++) {
                flat[j][i] &= reached[j][i] * fabs(fourth) <= allowed;
                flatter[j][i] &= farther[j][i] * fabs(fifth) <= allowed;
            }
        }
    EACH(i) {
        const long some = (b->known[i] > 0) & !(b->lapse[i] > 0.0) & resolved[i], more = b->known[i] > 1;
        smooth[i] = some & (flat[0][i] | (flatter[0][i] & more));
        before[i] = some & (flat[1][i] | (flatter[1][i] & more));
    }
}

/* the lowest and highest of each state at the last five points, of observed states or `all` */
static void find_bounds(const block *b, column *low, column *high, long all) {
    for (long k = 0; k < SIZE; k++) {
        if (!(all || observed[k])) continue;
        EACH(i) {
            const double at0 = b->node_state[0][k][i], at1 = b->node_state[1][k][i];
            const double at2 = b->state[k][i], at3 = b->half[k][i], at4 = b->full[k][i];
            low[k][i] = smaller(smaller(smaller(at0, at1), smaller(at2, at3)), at4);
            high[k][i] = larger(larger(larger(at0, at1), larger(at2, at3)), at4);
        }
    }
}

/* states on it at times; those that overshoot what they go through are no longer smooth. Observed states count in every
   lane, the others only in lanes that are `whole`, so that no lane depends on another. */
static void interpolate(const block *b, const column time, const column *per, const column *low, const column *high,
                        flags_of_lanes smooth, column *x, const flags_of_lanes whole) {
    const long all = any(whole);
    column w[5];
    EACH(i) {
        const double t0 = time[i] - b->node_time[0][i], t1 = time[i] - b->node_time[1][i];
        const double t2 = time[i] - b->time[i], t3 = t2 - 0.5 * b->length[i], t4 = t2 - b->length[i];
        const double early = t0 * t1, late = t3 * t4;
        w[0][i] = per[0][i] * t1 * t2 * late;
        w[1][i] = per[1][i] * t0 * t2 * late;
        w[2][i] = per[2][i] * early * late;
        w[3][i] = per[3][i] * early * t2 * t4;
        w[4][i] = per[4][i] * early * t2 * t3;
    }
    for (long k = 0; k < SIZE; k++) {
        const long long ignored = !is_judged_state(k), asked = observed[k];
        if (!(all || asked)) continue;
        EACH(i) {
            const double sum = w[0][i] * b->node_state[0][k][i] + w[1][i] * b->node_state[1][k][i] +
                               w[2][i] * b->state[k][i] + w[3][i] * b->half[k][i] + w[4][i] * b->full[k][i];
            const double least = low[k][i], most = high[k][i];
            const double hair = ROUNDING * (fabs(least) + fabs(most));
            const long long inside = (least - hair <= sum) & (sum <= most + hair);
            smooth[i] &= inside | ignored | !(asked | whole[i]);
            x[k][i] = smaller(larger(sum, least), most);
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
        find_reaches(d, half, 1, &r);
        for (long j = 0; j < TONES; j++) {
            EACH(i) at[j][0][i] = cos(d->speed[j][i] * centre[i] + d->phase[j][i]);
            EACH(i) at[j][1][i] = sin(d->speed[j][i] * centre[i] + d->phase[j][i]);
        }
        add_tones(d, at, &r, half, 1, found[k]);
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

/* a step to the next sample of a run from the start or the middle of the one taken, or of the one before, for later */
static void put_aside(const march *m, block *b, long i, double time, long leaving) {
    steps_aside *q = &b->aside;
    const int now = time > b->time[i];
    const double start = now ? b->time[i] : b->node_time[0][i];
    const double middle = now ? start + 0.5 * b->length[i] : b->node_time[1][i];
    const int late = ORDER != 4 && time > middle;
    const column *first = now ? b->state : b->node_state[0], *second = now ? b->half : b->node_state[1];
    const column *state = late ? second : first, *owed = now ? b->owed : b->owed_before;
    const long j = q->count++;
    q->run[j] = b->run[i];
    q->sample[j] = b->sample[i];
    q->leaving[j] = leaving;
    q->begin[j] = late ? middle : start;
    q->end[j] = time;
    for (long k = 0; k < CONSTANTS; k++) q->c[k][j] = b->c[k][i];
    for (long k = 0; k < SIZE; k++) q->x[k][j] = state[k][i];
#if ORDER != 4
    const column *third = now ? b->full : b->state, *ahead = late ? third : second;
    const double share = (time - q->begin[j]) / (middle - start);
    for (long k = 0; k < SIZE; k++) q->line[k][j] = state[k][i] + share * (ahead[k][i] - state[k][i]);
#endif
    for (long k = 0; k < DRIVES; k++) {
        q->owed[k][j] = late ? 0.0 : owed[k][i];
        copy_lane(b->now + k, i, q->then + k, j);
        if (!now) find_segment(m, q->then + k, k, j, start);
    }
    if (q->count == LANES) finish_aside(m, q);
}

/* states of a march within a hair of a time, in the step taken or the one before; none if there are none */
static const column *find_node(const block *b, long i, double time, double end) {
    const double hair = STEP_TOLERANCE * b->length[i], middle = b->time[i] + 0.5 * b->length[i];
    if (time >= end - hair) return b->full;
    if ((LANES > 1 || ORDER != 4) && fabs(time - middle) <= hair) return b->half;
    if (fabs(time - b->time[i]) <= hair) return b->state;
    if ((LANES > 1 || ORDER != 4) && fabs(time - b->node_time[1][i]) <= hair) return b->node_state[1];
    return 0;
}

/* Outputs at the samples within the steps that were taken. Those that no polynomial reaches wait for the next step, if
   it may go on from this one, and otherwise for a step aside. */
static void keep_samples(const march *m, block *b, const flags_of_lanes taken, const column end,
                         const flags_of_lanes edge) {
    column time, per[5], last, near, low[SIZE + 1], high[SIZE + 1];
    flags_of_lanes due, smooth, before, good, other, within, ends, waits = {0};
    flags_of_lanes whole; /* whether all states are tested */
    long leaving = 0, found = 0;
    EACH(i) {
        last[i] = taken[i] ? end[i] + STEP_TOLERANCE * b->length[i] : -1.0;
        near[i] = end[i] - STEP_TOLERANCE * b->length[i];
        ends[i] = edge[i] | (b->lapse[i] > 0.0) | !(end[i] < m->duration);
        whole[i] = LANES == 1;
    }
    for (long k = 0; k < ENVELOPE; k++)
        EVERY(i) {
            const long outside = taken[i] & !is_inside(b, b->fine, k, i);
            leaving |= outside;
            whole[i] |= outside;
            ends[i] |= outside;
        }
    for (;;) {
        EACH(i) {
            due[i] = (b->coming[i] <= last[i]) & !waits[i];
            time[i] = due[i] ? b->coming[i] : end[i];
        }
        if (!any(due)) return;
#if ORDER == 5
        EACH(i) other[i] = due[i] & !(b->on_surface[i] & (b->time[i] < time[i]) & (time[i] < near[i]));
        if (!any(other)) {
            follow_slopes(b, time, due, leaving, b->x2);
            keep_rows(m, b, time, bits_of(due), leaving);
            EACH(i) {
                b->sample[i] += due[i];
                b->coming[i] = m->times[b->sample[i]];
            }
            continue;
        }
#endif
        EACH(i) {
            within[i] = ORDER == 5 && b->on_surface[i] & (time[i] > b->time[i]);
            good[i] = within[i];
            other[i] = due[i] & !within[i];
        }
        if (any(other)) {
            if (!found) {
                find_smooth(m, b, smooth, before, per);
                find_bounds(b, low, high, any(whole));
                found = 1;
            }
            EACH(i) good[i] = time[i] > b->time[i] ? smooth[i] : before[i];
            interpolate(b, time, per, low, high, good, b->x2, whole);
            EACH(i) good[i] |= within[i];
        }
#if ORDER == 5
        if (any(within)) follow_slopes(b, time, within, leaving, b->x2);
#endif
        EACH(i) other[i] = due[i] & (!good[i] | (time[i] >= near[i]));
        SOME(i, bits_of(other)) {
            const column *node = find_node(b, i, time[i], end[i]);
            good[i] = node ? 1 : -1;
            if (node) {
                for (long k = 0; k < SIZE; k++) b->x2[k][i] = node[k][i];
            } else if (time[i] > b->time[i] && !ends[i]) {
                waits[i] = 1;
            } else {
                put_aside(m, b, i, time[i], leaving);
            }
        }
        EACH(i) other[i] = due[i] & (good[i] >= 0);
        const unsigned long long shown = bits_of(other);
        if (shown) keep_rows(m, b, time, shown, leaving);
        EACH(i) {
            b->sample[i] += due[i] & !waits[i];
            b->coming[i] = m->times[b->sample[i]];
        }
    }
}

/* the samples that wait for a step which cannot be taken */
static void keep_waiting(const march *m, block *b, long i) {
    for (; b->coming[i] <= b->time[i]; b->coming[i] = m->times[++b->sample[i]]) put_aside(m, b, i, b->coming[i], 0);
}
