/* The march with an error control in every step: martensite/simulate/adaptive.py, over lanes.

   Before this text stand kinks.c and samples.c with what they ask for, and PLACES (the drive of each known heat). The
   kernels are k_ripple, k_points, and by the ORDER of a step k_solve (2), k_rosenbrock (4), or k_solve with k_surface
   and k_events of surface.c (5). SAFETY and other numbers are those of adaptive.py, of the same names. */

#define LEAST_ERROR 1e-9
#define IS_SURFACE(i) (ORDER == 5 && b->on_surface[i])
#define PART(i) (ORDER == 4 || IS_SURFACE(i) ? 1.0 : 1.0 / 3.0)
#define POWER(i) (IS_SURFACE(i) ? 0.2 : 1.0 / 3.0) /* of an error, for the length of a step without rates */

static const long places[HEATED + 1] = PLACES;

#if ORDER == 4
/* one step where laws give rates: its end, its middle, and its end to a lower order */
static void solve_steps(const march *m, block *b) {
    column whole[DRIVES + 1][MOMENTS];
    (void)m;
    for (long k = 0; k < DRIVES; k++) join(b, k, whole[k]);
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
static void solve_halves(block *b) {
    column whole[DRIVES + 1][MOMENTS], half, gap;
    for (long k = 0; k < DRIVES; k++) join(b, k, whole[k]);
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

#if ORDER == 5
/* steps of order five where drives are smooth and the heat balance is slower than a step; others in halves */
static void solve_steps(const march *m, block *b) {
    flags_of_lanes others;
    const double phase = (1.0 + STEP_TOLERANCE) * b->phase;
    const double least = LEAST_SMOOTH * m->duration;
    EACH(i) {
        const long long slow = b->decay[i] * b->length[i] <= STIFF;
        b->on_surface[i] = !(b->lapse[i] > 0.0) & slow & (b->length[i] > least);
    }
    for (long k = 0; k < DRIVES; k++)
        EVERY(i) b->on_surface[i] &= drive_of(m, b->now + k, k, i)->fastest * b->length[i] <= phase;
    EACH(i) others[i] = b->live[i] & !b->on_surface[i];
    if (any(others)) {
        for (long k = 0; k < DRIVES && !needs_squares(m); k++)
            if (widths[k] > 1) bring_halves(m, b, k, others, 1);
        solve_halves(b);
    }
    if (!any(b->on_surface)) return;
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, b->owed, b->length, b->x0 + SIZE);
    feed(b->two, 0, b->length, b->x0 + SIZE + INPUTS);
    k_surface(LANES, *b->c, *b->x0, *b->ends);
    for (long k = 0; k < SIZE; k++) {
        BLEND(b->full[k], b->on_surface, b->ends[k]);
        BLEND(b->half[k], b->on_surface, b->ends[SIZE + k]);
        BLEND(b->whole[k], b->on_surface, b->ends[2 * SIZE + k]);
    }
    EACH(i) {
        const long on = b->on_surface[i] != 0;
        b->full[SIZE][i] = on ? smaller(b->ends[RESIDUAL][i], SOLVED) : b->full[SIZE][i];
        b->half[SIZE][i] = on ? 0.0 : b->half[SIZE][i];
        b->whole[SIZE][i] = on ? 0.0 : b->whole[SIZE][i];
        b->decay[i] = b->on_surface[i] ? b->ends[DECAY][i] / b->length[i] : b->decay[i];
    }
    place_events(b);
}
#else
static void solve_steps(const march *m, block *b) {
    (void)m;
    solve_halves(b);
}
#endif

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
    column half, end, middle;
    EACH(i) {
        half[i] = 0.5 * b->length[i];
        middle[i] = b->time[i] + half[i];
        end[i] = b->time[i] + b->length[i];
    }
    solve_steps(m, b);
    find_ripples(b, half);
    k_points(LANES, *b->c, *b->half, *b->points_half);
    k_points(LANES, *b->c, *b->full, *b->points_full);
    judge_at(m, b, b->whole, end, 1, b->coarse);
    judge_at(m, b, b->half, middle, 0, b->middle);
    judge_at(m, b, b->full, end, 1, b->fine);
    check_middles(m, b, half, middle);
    if (FOLLOWS) judge_at(m, b, b->state, b->time, 0, b->onset);
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
        b->error[i] = IS_SURFACE(i) ? b->ends[RESIDUAL][i] / SOLVED : 0.0;
        broken[i] = 0.0;
    }
    for (long k = 0; k < SEEN; k++)
        EACH(i) broken[i] += 0.0 * b->fine[k][i] + 0.0 * b->coarse[k][i];
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double apart = PART(i) * fabs(b->fine[k][i] - b->coarse[k][i]);
            const double wider = larger(b->fine[k][i] - b->low[k][i], b->high[k][i] - b->fine[k][i]);
            const double most = k ? apart : larger(apart, ripple[i]);
            b->error[i] = larger(b->error[i], most / larger(b->scale[k][i], wider) * per);
        }
    EACH(i) {
        const double wider = larger(b->fine[0][i] - b->low[0][i], b->high[0][i] - b->fine[0][i]);
        const double allowed = m->tolerance * larger(b->scale[0][i], wider);
        b->accurate[i] = JUDGED && ORDER == 5 && fabs(b->fine[0][i] - b->coarse[0][i]) <= allowed;
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
    flags_of_lanes grew;
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
        rough[i] = used / (ORDER == 4 ? cube * length : IS_SURFACE(i) ? cube * length * length : cube);
        grew[i] = !IS_SURFACE(i) & (b->rough[i] > 0.0) & (b->rough[i] < rough[i]);
        change[i] = SAFETY * (ORDER == 4 ? 1.0 / sqrt(sqrt(used)) : exp(-POWER(i) * log(used)));
        slowing[i] = change[i];
    }
    if (any(grew)) EACH(i) {
            const double falls = grew[i] ? b->rough[i] / rough[i] : 1.0;
            slowing[i] *= ORDER == 4 ? sqrt(sqrt(falls)) : exp(POWER(i) * log(falls));
        }
    EVERY(i) if (b->live[i] && b->length[i] <= shortest && b->error[i] == HUGE_VAL)
        b->status[i] = residual[i] > SOLVED ? UNSOLVED : NOT_FINITE;
    /* steps that are taken */
    EACH(i) {
        const long long t = taken[i], kinked = b->planned[i] > 0.0;
        const double length = b->length[i], grows = smaller(slowing[i], b->grows[i]);
        const double grown = length * larger(grows, LEAST_CHANGE);
        const double after_kink = b->at_kink[i] ? MOST_CHANGE * length : b->after_kink[i];
        const double bound = !kinked | (after_kink > grown) ? after_kink : grown;
        const double planned = larger(grown, b->planned[i]);
        const double limited = kinked & !IS_SURFACE(i) ? smaller(planned, bound) : planned;
        const double next = larger(limited, shortest);
        b->ripple[i] = t ? larger(ripple[i], b->ripple[i]) : b->ripple[i];
        const long long missed = (b->error[i] > 1.0) & (b->error[i] < HUGE_VAL); /* no step is shorter */
        const double left = larger(residual[i], b->residual[i]) + (missed ? m->tolerance * b->error[i] : 0.0);
        b->residual[i] = t ? left : b->residual[i];
        b->after_kink[i] = t ? after_kink : b->after_kink[i];
        b->at_kink[i] = t ? kinked : b->at_kink[i];
        b->rough[i] = t ? (kinked ? 0.0 : rough[i]) : b->rough[i];
        b->next[i] = t ? next : b->next[i];
        b->cut[i] &= !t;
    }
    /* those that are made again */
    flags_of_lanes again;
    EACH(i) again[i] = b->live[i] & !taken[i];
    SOME(i, bits_of(again)) {
        const double length = b->length[i];
        const int solved = b->error[i] < HUGE_VAL, good = b->error[i] <= 1.0;
        double shorter = solved ? length : 0.25 * length;
        b->rejected[i] += 1.0;
        if (good)
            b->planned[i] = larger(length, b->planned[i]);
        else
            b->grows[i] = 1.0;
        const double kink = b->kink[i], least = IS_SURFACE(i) ? LEAST_SHRINK : LEAST_CHANGE;
        const int explains = !IS_SURFACE(i) || good || (b->accurate[i] && !(b->cut[i] && kink > AGAIN));
        b->cut[i] = kink < 1.0;
        if (kink < 1.0 && explains) {
            shorter = kink * length;
        } else if (solved) {
            shorter = length * smaller(smaller(larger(change[i], least), SAFETY), kink);
            if (b->power[i] * b->lapse[i] > m->tolerance * (JUDGED ? b->scale[0][i] : 1.0))
                shorter = smaller(shorter, to_edge(m, b, i));
        }
        b->length[i] = larger(shorter, 0.5 * shortest);
    }
}

/* ------------------------------------------------------------------ the way through time */

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

static void accept_steps(march *m, block *b, flags_of_lanes taken) {
    column end;
    flags_of_lanes edge, stuck;
    EACH(i) stuck[i] = taken[i] & (b->status[i] != OK);
    SOME(i, bits_of(stuck)) { /* it has no solution here, and ends where it began */
        keep_waiting(m, b, i);
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
        flags_of_lanes near;
        EACH(i) near[i] = b->now[k].following[i] < end[i] + 2.0 * STEP_TOLERANCE * b->length[i];
        if (!any(near)) continue;
        EVERY(i) if (taken[i]) edge[i] = is_edge(m, b, i, end[i]);
        break;
    }
#if LEDGER
    if (m->recording) keep_ledger(m, b);
#endif
    keep_samples(m, b, taken, end, edge);
#if FORKS
    watch_forks(m, b, taken, end);
#endif
    EVERY(i) if (m->recording && taken[i] && b->live[i]) {
        const double middle = b->time[i] + 0.5 * b->length[i];
        record_piece(m, b, i, 1.0, b->time[i], middle, b->one, b->half);
        record_piece(m, b, i, 2.0, middle, end[i], b->two, b->full);
    }
    if (m->totals) {
        long long counted[LANES];
        EVERY(i) {
            counted[i] = taken[i] && b->live[i];
            for (long k = 0; k < ENVELOPE; k++) counted[i] &= is_inside(b, b->fine, k, i);
        }
        add_totals(m, b, counted);
    }
    EACH(i) {
        const long t = taken[i], at = edge[i];
        const double length = b->length[i];
        const double after_edge = b->at_edge[i] && !b->leaps[i] ? MOST_CHANGE * length : b->after_edge[i];
        const long whole = ORDER == 4 || IS_SURFACE(i);
        b->steps[i] += t ? (whole ? 1.0 : 2.0) : 0.0;
        b->longest[i] = t ? larger(whole ? length : 0.5 * length, b->longest[i]) : b->longest[i];
        b->after_edge[i] = t ? after_edge : b->after_edge[i];
        b->next[i] = t && at ? smaller(b->next[i], after_edge) : b->next[i];
        b->rough[i] = t && at ? 0.0 : b->rough[i];
        b->at_edge[i] = t ? at : b->at_edge[i];
        const long more = b->known[i] < DEEPEST ? b->known[i] + 1 : DEEPEST;
        b->known[i] = t ? (at | (b->lapse[i] > 0.0) ? 0 : more) : b->known[i];
        b->older_time[i] = t ? b->node_time[1][i] : b->older_time[i];
        b->split[i] &= !(t & at);
        b->last_half[i] = t ? 0.5 * length : b->last_half[i];
        b->node_time[0][i] = t ? b->time[i] : b->node_time[0][i];
        b->node_time[1][i] = t ? b->time[i] + 0.5 * length : b->node_time[1][i];
        b->time[i] = t ? end[i] : b->time[i];
        b->fresh[i] = t;
    }
    for (long k = 0; k < DRIVES; k++) BLEND(b->owed_before[k], taken, b->owed[k]);
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
    }
    for (long k = 0; k < NUMBERS; k++) {
        BLEND(b->earlier_points[k], taken, b->points_half[k]);
        BLEND(b->points[k], taken, b->points_full[k]);
    }
    for (long k = 0; k < HEATED && ORDER != 4; k++) {
        const double *fine = b->fine[JUDGED + ENVELOPE + k], *coarse = b->coarse[JUDGED + ENVELOPE + k];
        EACH(i) {
            const double owed = IS_SURFACE(i) ? 0.0 : PART(i) * (fine[i] - coarse[i]);
            b->owed[places[k]][i] = taken[i] ? owed : b->owed[places[k]][i];
        }
    }
    see(m, b, b->fine, taken);
}

/* the points of laws where runs begin */
static void begin_points(block *b, const flags_of_lanes begins) {
    column points[NUMBERS + 1];
    if (!any(begins)) return;
    k_points(LANES, *b->c, *b->state, *points);
#if FORKS
    begin_forks(b, begins);
#endif
    for (long k = 0; k < NUMBERS; k++) {
        BLEND(b->points[k], begins, points[k]);
        BLEND(b->earlier_points[k], begins, points[k]);
    }
}

static long go_on(march *m, block *b) {
    flags_of_lanes begins, taken;
    if (is_full(m)) return RECORD;
    if (!begin_runs(m, b, begins)) {
        finish_aside(m, &b->aside);
        return DONE;
    }
    if (!any(b->live)) return PAUSED;
    begin_points(b, begins);
#if LEDGER
    if (any(begins)) begin_ledger(m, b);
#endif
    find_segments(m, b);
    plan_lengths(m, b);
    if (!knows_drives(m, b, b->time[0] + (1.0 + 2.0 * STEP_TOLERANCE) * b->length[0])) return SIGNALS;
    EVERY(i) b->fresh[i] = 0;
    resolve_lengths(m, b);
    try_steps(m, b);
    judge_steps(m, b, taken);
    accept_steps(m, b, taken);
    return PAUSED;
}
