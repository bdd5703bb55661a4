/* The march of one run on given steps, as in martensite/simulate/march.py: equal ones between samples and edges of the
   drives. Before this text stands runs.c with what it asks for, and the kernel k_step. */

#define COARSE 0.2
#define CLOSE (1e-12 * m->duration) /* time that counts as zero */

/* the next sample, or edge of a drive */
static double next_stop(const march *m, const block *b) {
    double end = b->coming[0] - CLOSE;
    for (long k = 0; k < DRIVES; k++) {
        long count;
        end = first_edge(drive_of(m, b->now + k, k, 0), b->time[0] + CLOSE, end, b->now[k].cursor[0], &count);
    }
    return end < b->coming[0] - CLOSE ? end : b->coming[0];
}

/* cut the way to the next sample or edge into equal steps */
static void plan_pieces(const march *m, block *b) {
    find_segments(m, b);
    b->begin = b->time[0];
    b->stop = next_stop(m, b);
    b->pieces = larger(ceil((b->stop - b->begin) / m->step - STEP_TOLERANCE), 1.0);
    b->length[0] = (b->stop - b->begin) / b->pieces;
    b->piece = 0.0;
}

static void take_step(march *m, block *b, double begin, const column end) {
    const flags_of_lanes taken = {1};
    for (long k = 0; k < DRIVES; k++)
        if (widths[k] > 1)
            bring(m, b->now + k, k, 0, begin, end[0], b->one[k]);
        else
            b->one[k][MEAN][0] = value_of(m, b, k, 0, end[0], 1);
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, 0, b->length, b->x0 + SIZE);
    k_step(LANES, *b->c, *b->x0, *b->whole);
    const double residual = b->whole[SIZE][0], crossing = b->whole[SIZE + 1][0];
    const long status = !isfinite(residual) || !isfinite(crossing) ? NOT_FINITE :
                        residual > SOLVED ? UNSOLVED : crossing > COARSE ? LONG_STEP : OK;
    b->residual[0] = larger(residual, b->residual[0]);
    b->ripple[0] = larger(b->whole[SIZE + 2][0], b->ripple[0]);
    if (status > b->status[0]) {
        b->status[0] = status;
        b->status_time[0] = begin;
    }
    b->steps[0] += 1.0;
    b->longest[0] = larger(b->length[0], b->longest[0]);
    memcpy(b->state, b->whole, sizeof(column) * SIZE);
    record_piece(m, b, 0, 0.0, begin, end[0], b->one, b->state);
    b->time[0] = begin;
    judge_at(m, b, b->state, end, 1, b->fine);
    see(m, b, b->fine, taken);
}

static long go_on(march *m, block *b) {
    flags_of_lanes begins;
    if (is_full(m)) return RECORD;
    if (!begin_runs(m, b, begins)) return DONE;
    if (!b->live[0]) return PAUSED;
    if (b->fresh[0]) {
        if (!knows_drives(m, b, b->time[0] + CLOSE)) return SIGNALS;
        plan_pieces(m, b);
        b->fresh[0] = 0;
    }
    const double begin = b->begin + b->piece * b->length[0];
    b->piece += 1.0;
    const column end = {b->piece < b->pieces ? begin + b->length[0] : b->stop};
    take_step(m, b, begin, end);
    if (b->piece < b->pieces || !b->live[0]) return PAUSED;
    b->time[0] = b->stop;
    b->fresh[0] = 1;
    if (b->time[0] == b->coming[0]) {
        memcpy(b->x2, b->state, sizeof(column) * SIZE);
        keep_rows(m, b, b->time, 1, 0);
        b->coming[0] = m->times[++b->sample[0]];
    }
    end_runs(m, b);
    return PAUSED;
}
