/* The march on given steps, as in martensite/simulate/march.py: equal ones between samples and edges of
   the drives. Before this text stand martensite/simulate/marching.c with what it asks for, and the
   kernel k_step. */

#define COARSE 0.2

/* the next sample, or edge of a drive */
static double next_stop(const march *m, const block *b) {
    const double sample = m->times[b->sample], hair = 1e-12 * m->duration;
    double end = sample - hair;
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            long count;
            const drive *d = drives_of(m, b, set) + i;
            end = first_edge(d, b->time + hair, end, b->cursor[set][i], &count);
        }
    return end < sample - hair ? end : sample;
}

static void take_step(march *m, block *b, double begin, double length, double end) {
    bring(m, b, begin, end, b->one);
    memcpy(b->x0, b->state, sizeof(column) * SIZE);
    feed(b->one, 0, length, b->x0 + SIZE);
    k_step(LANES, *b->c, *b->x0, *b->whole);
    LIVE(i) {
        const double residual = b->whole[SIZE][i], crossing = b->whole[SIZE + 1][i];
        const double ripple = b->whole[SIZE + 2][i];
        const long status = !isfinite(residual) || !isfinite(crossing) ? NOT_FINITE :
                            residual > SOLVED ? UNSOLVED : crossing > COARSE ? LONG_STEP : OK;
        b->residual[i] = residual > b->residual[i] ? residual : b->residual[i];
        b->ripple[i] = ripple > b->ripple[i] ? ripple : b->ripple[i];
        if (status > b->status[i]) {
            b->status[i] = status;
            b->status_time[i] = begin;
        }
    }
    b->steps++;
    b->longest = length > b->longest ? length : b->longest;
    memcpy(b->state, b->whole, sizeof(column) * SIZE);
    record_piece(m, b, 0.0, begin, end, b->one[0], b->state);
    b->time = begin;
    judge_at(m, b, b->state, end, 1, b->fine);
    see(m, b, b->fine);
    end_runs(m, b);
}

/* cut the way to the next sample or edge into equal steps */
static void plan_pieces(const march *m, block *b) {
    move_cursors(m, b);
    b->begin = b->time;
    b->stop = next_stop(m, b);
    b->pieces = ceil((b->stop - b->begin) / m->step - STEP_TOLERANCE);
    b->pieces = b->pieces > 1.0 ? b->pieces : 1.0;
    b->length = (b->stop - b->begin) / b->pieces;
    b->piece = 0.0;
}

/* Go on for some rounds. Returns DONE, PAUSED, SIGNALS if drives must be known further, or RECORD if the
   record is full. */
long march_on(march *m, block *b, long begin) {
    if (begin) b->begun = 0;
    for (long round = 0; round < m->rounds; round++) {
        while (!any_live(b)) {
            const long next = b->begun ? b->first_run + LANES : 0;
            if (next >= m->runs) return DONE;
            if (is_full(m)) return RECORD;
            begin_block(m, b, next);
            b->length = 0.0; /* of steps that are not planned yet */
        }
        if (is_full(m)) return RECORD;
        if (b->length == 0.0) {
            if (!known_until(m, b, b->time + 1e-12 * m->duration)) return SIGNALS;
            plan_pieces(m, b);
        }
        const double begin = b->begin + b->piece * b->length;
        const int last = !(b->piece + 1.0 < b->pieces);
        take_step(m, b, begin, b->length, last ? b->stop : begin + b->length);
        if (++b->piece < b->pieces || !any_live(b)) continue;
        b->time = b->stop;
        b->length = 0.0;
        if (b->time == m->times[b->sample]) {
            memcpy(b->x2, b->state, sizeof(column) * SIZE);
            keep_rows(m, b, b->time);
        }
        end_runs(m, b);
    }
    return PAUSED;
}
