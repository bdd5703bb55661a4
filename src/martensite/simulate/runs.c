/* Runs of a march: their start, their ends, and the rows that are kept of them. */

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

INLINE int is_inside(const block *b, const column *seen, long k, long i) {
    return (b->limits[k][i] <= seen[JUDGED + k][i]) & (seen[JUDGED + k][i] <= b->limits[ENVELOPE + k][i]);
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

static void judge_at(const march *m, block *b, const column *states, const column time, int before,
                     column *seen) {
    memcpy(b->x2, states, sizeof(column) * SIZE);
    if (JUDGE_SIGNALS) put_signals(m, b, time, before, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *seen);
}

static void tell(const march *m, block *b, long i) {
    const long run = b->run[i];
    double *n = m->numbers + run * (SAID + JUDGED), *ends = m->extremes + run * 2 * JUDGED;
    n[0] = (double)b->status[i];
    n[1] = b->status[i] == LONG_STEP ? b->status_time[i] : b->time[i];
    n[2] = (double)b->place[i];
    n[3] = b->place[i] < 0 ? 0.0 : b->seen[JUDGED + b->place[i]][i];
    n[4] = b->steps[i];
    n[5] = b->rejected[i];
    n[6] = b->longest[i];
    n[7] = b->ripple[i];
    n[8] = b->residual[i];
    n[9] = b->put_in[i];
    n[10] = b->lost[i];
    for (long k = 0; k < ACCOUNTS; k++) n[11 + k] = b->accounts[k][i];
    for (long k = 0; k < DECIDED; k++) n[11 + ACCOUNTS + k] = b->decided[k][i];
    for (long k = 0; k < JUDGED; k++) {
        n[SAID + k] = b->high[k][i] - b->low[k][i];
        ends[k] = b->low[k][i];
        ends[JUDGED + k] = b->high[k][i];
    }
    for (long k = 0; k < SIZE; k++) m->states[run * SIZE + k] = b->state[k][i];
    tell_totals(m, b, run, i);
    b->live[i] = 0;
    b->loaded[i] = b->status[i] < UNSOLVED; /* a failed state may be slow to solve in every step */
    b->done++;
}

static void scale_ranges(block *b) {
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double least = larger(b->range[k][i], floors[k]);
            b->scale[k][i] = larger(b->high[k][i] - b->low[k][i], least);
        }
}

/* end runs that are outside of the envelope, complete, or not solved */
static void end_runs(const march *m, block *b) {
    flags_of_lanes outside, ends;
    EACH(i) outside[i] = 0;
    for (long k = 0; k < ENVELOPE; k++) EACH(i) outside[i] |= !is_inside(b, b->seen, k, i);
    for (long k = 0; k < ENVELOPE && any(outside); k++)
        EVERY(i) if (b->live[i] && b->status[i] < UNSOLVED && !is_inside(b, b->seen, k, i)) {
            b->status[i] = isfinite(b->seen[JUDGED + k][i]) ? OUT_OF_ENVELOPE : NOT_FINITE;
            b->place[i] = k;
        }
    EACH(i) ends[i] = b->live[i] & ((b->status[i] >= UNSOLVED) | !(b->time[i] < m->duration));
    SOME(i, bits_of(ends)) tell(m, b, i);
}

/* go to the ends of steps that were taken; `seen` is judged there */
static void see(const march *m, block *b, const column *seen, const flags_of_lanes taken) {
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            b->low[k][i] = taken[i] ? smaller(seen[k][i], b->low[k][i]) : b->low[k][i];
            b->high[k][i] = taken[i] ? larger(seen[k][i], b->high[k][i]) : b->high[k][i];
        }
    for (long k = 0; k < SEEN; k++) BLEND(b->seen[k], taken, seen[k]);
    scale_ranges(b);
    end_runs(m, b);
}

/* outputs of the states in x2, for lanes that ask and are inside the envelope */
static void keep_rows(const march *m, block *b, const column time, unsigned long long asked, long leaving) {
    flags_of_lanes gone;
    column signals[DRIVES + 1];
    if (OBSERVE_SIGNALS || (leaving && JUDGE_SIGNALS)) put_signals(m, b, time, 0, signals);
    if (leaving) find_gone(m, b->c, b->x2, signals, b->run, gone);
    if (OBSERVE_SIGNALS) memcpy(b->x2 + SIZE, signals, sizeof(column) * DRIVES);
    k_observe(LANES, *b->c, *b->x2, *b->row);
    SOME(i, asked) if (!(leaving && gone[i])) {
        double *row = m->rows + (b->run[i] * m->samples + b->sample[i]) * OUTPUTS;
        for (long k = 0; k < OUTPUTS; k++) row[k] = b->row[k][i];
    }
}

/* put a run into a lane */
static void load_run(const march *m, block *b, long i, long run) {
    b->run[i] = run;
    b->status[i] = OK;
    b->place[i] = -1;
    b->sample[i] = b->at_edge[i] = 1;
    b->coming[i] = m->times[1];
    b->at_kink[i] = b->known[i] = b->split[i] = b->cut[i] = b->on_surface[i] = 0;
    b->time[i] = m->times[0];
    b->decay[i] = b->power[i] = b->lapse[i] = b->rough[i] = b->steps[i] = b->rejected[i] = 0.0;
    b->longest[i] = b->ripple[i] = b->residual[i] = b->put_in[i] = b->lost[i] = 0.0;
    for (long k = 0; k < ACCOUNTS; k++) b->accounts[k][i] = 0.0;
    b->next[i] = b->after_edge[i] = b->last_half[i] = b->length[i] = m->first[run];
    b->after_kink[i] = HUGE_VAL;
    for (long k = 0; k < DECIDED; k++) b->decided[k][i] = k ? 0.0 : HUGE_VAL;
    b->decided[3][i] = -1.0;
    for (long k = 0; k < PARAMETERS; k++) b->p[k][i] = m->p[k * m->runs + run];
    for (long k = 0; k < 2 * ENVELOPE; k++) b->limits[k][i] = m->limits[k * m->runs + run];
    for (long k = 0; k < JUDGED; k++) b->range[k][i] = m->ranges[run * JUDGED + k];
    for (long k = 0; k < RATES; k++) b->rate[k][i] = 0.0;
    for (long k = 0; k < DRIVES; k++) {
        b->now[k].run[i] = run;
        b->now[k].cursor[i] = b->now[k].ready[i] = 0;
        const drive *d = drive_of(m, b->now + k, k, i);
        b->owed[k][i] = 0.0;
        for (long j = 0; j < TONES; j++) {
            b->now[k].amplitude[j][i] = j < d->tones ? d->amplitude[j] : 0.0;
            b->now[k].speed[j][i] = j < d->tones ? d->rate[j] : 0.0;
            b->now[k].phase[j][i] = j < d->tones ? d->phase[j] : 0.0;
        }
    }
}

/* Begin runs in lanes that have none, and say in which. A lane for which no run is left repeats a step of the first
   run; its results are not kept. Returns 0 if all runs are done. */
static long begin_runs(march *m, block *b, flags_of_lanes begins) {
    column state[SIZE + 1], seen[SEEN + 1], start;
    long idle = 0, broken = 0;
    EVERY(i) {
        begins[i] = 0;
        idle += !b->live[i];
        broken |= !b->loaded[i];
    }
    const long left = b->end_run - b->next_run;
    if (idle == LANES && !left) return 0;
    if (!broken && !(left && (idle >= IDLE || idle == LANES))) return 1;
    EVERY(i) {
        const long next = !b->live[i] && b->next_run < b->end_run;
        begins[i] = next || !b->loaded[i];
        if (begins[i]) load_run(m, b, i, next ? b->next_run : 0);
        if (next) b->next_run++;
        b->live[i] |= next;
        b->loaded[i] = 1;
        start[i] = begins[i] ? m->times[0] : b->time[i];
    }
    k_prepare(LANES, *b->p, *b->c);
    put_signals(m, b, start, 0, b->x0);
    k_init(LANES, *b->c, *b->x0, *state);
    for (long k = 0; k < SIZE && m->placed; k++) EVERY(i) state[k][i] = m->states[b->run[i] * SIZE + k];
    memcpy(b->x2, state, sizeof(column) * SIZE);
    put_signals(m, b, start, 0, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *seen);
    k_observe(LANES, *b->c, *b->x2, *b->row);
    EVERY(i) if (begins[i]) {
        const double *before = m->extremes + b->run[i] * 2 * JUDGED;
        b->fresh[i] = 1;
        for (long k = 0; k < SIZE; k++) b->state[k][i] = state[k][i];
        for (long k = 0; k < SEEN; k++) b->seen[k][i] = seen[k][i];
        for (long k = 0; k < JUDGED; k++) {
            b->low[k][i] = smaller(before[k], seen[k][i]);
            b->high[k][i] = larger(before[JUDGED + k], seen[k][i]);
        }
        double *row = m->rows + b->run[i] * m->samples * OUTPUTS;
        for (long k = 0; k < OUTPUTS && b->live[i]; k++) row[k] = b->row[k][i];
        if (b->live[i]) record_piece(m, b, i, -1.0, start[i], start[i], b->one, b->state);
    }
    begin_totals(b, b->row, begins);
    scale_ranges(b);
    end_runs(m, b);
    return 1;
}

/* prepare for the runs from `first` to before `end` */
static void begin_block(const march *m, block *b, long first, long end) {
    memset(b, 0, sizeof *b);
#if ORDER == 5
    const double share = m->tolerance / SMOOTH_TOLERANCE;
    b->phase = share < 1.0 ? SMOOTH_PHASE * exp(log(share) * (1.0 / 6.0)) : SMOOTH_PHASE;
#endif
    b->next_run = first;
    b->end_run = end;
}

/* whether the drives of one run are known up to a time; those of a batch are complete */
static int knows_drives(const march *m, const block *b, double time) {
    for (long k = 0; k < DRIVES && LANES == 1; k++) {
        const drive *d = drive_of(m, b->now + k, k, 0);
        if (!d->whole && !(d->start[d->count - 1] > time)) return 0;
    }
    return 1;
}

/* whether a step of every lane, or the start of a run, may not fit into the record */
static int is_full(const march *m) { return m->recording && m->recorded + 3 * LANES > m->capacity; }

/* one step of every lane, or a trial of it */
static long go_on(march *m, block *b);

/* Go on for some rounds. Returns DONE, PAUSED, SIGNALS if drives must be known further, or RECORD if the record is
   full. */
long march_on(march *m, block *b, long begin) {
    long answer = PAUSED;
    if (begin) begin_block(m, b, 0, m->runs);
    for (long round = 0; round < m->rounds && answer == PAUSED; round++) answer = go_on(m, b);
    return answer;
}

long size_of_block(void) { return sizeof(block); }

/* the start of the last step of one run; in a batch the number of runs that are done */
double time_of(const block *b) {
    return LANES > 1 ? (double)b->done : b->known[0] ? b->node_time[0][0] : b->time[0];
}

void forget_cursors(block *b) {
    for (long k = 0; k < DRIVES; k++) b->now[k].cursor[0] = 0;
}
