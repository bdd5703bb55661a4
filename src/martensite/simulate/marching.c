/* What marches of runs in C have in common: martensite/simulate/adaptive.c and fixed.c. LANES runs go
   together, on steps that they share.

   Before this text stand martensite/signals/reader.c, the kernels k_prepare, k_init, k_observe and
   k_judge over LANES lanes, and: SIZE states, DRIVES signals, INPUTS of a step, OUTPUTS wanted, JUDGED,
   ENVELOPE, HEATED, CONSTANTS, PARAMETERS; WIDTHS (inputs of each drive) and LEAST (range of each
   judged output that counts); OWN if every run has drives of its own; whether k_judge and k_observe
   ask for signals; how many numbers a piece of a step is RECORDED by; POINTS, all their NUMBERS, and RATES of adaptive.c; ENTRIES and ACCOUNTS of
   ledger.c. */

#define SEEN (JUDGED + ENVELOPE + HEATED)
#define REPORTS 3
#define SAID (11 + ACCOUNTS)
#define SETS (OWN ? LANES : 1)
#define EACH(i) for (long i = 0; i < LANES; i++)
#define LIVE(i) for (long i = 0; i < LANES; i++) if (b->live[i])

enum { OK = 0, LONG_STEP = 1, UNSOLVED = 2, NOT_FINITE = 4, OUT_OF_ENVELOPE = 7 };
enum { DONE = 0, PAUSED = 1, SIGNALS = 2, RECORD = 3 };

static const long widths[DRIVES + 1] = WIDTHS;
static const double floors[JUDGED + 1] = LEAST;
static const long observed[SIZE + 1] = OBSERVED; /* whether outputs depend on a state */

enum { MEAN, SQUARE, LOW, HIGH, LAPSE }; /* numbers of moments, in their order */
#define BROUGHT(part, k, which, i) (((const double *)((part) ? b->two[0] + (k) : b->one[0] + (k)))[which])
#define LEVEL(k, i, time, before) value_at(drives_of(m, b, 0) + (k), time, b->cursor[0][k], before)
#define OF_LANE(number, i) (number)

typedef double column[LANES];

/* runs that go together: where they are, and the step that is tried */
typedef struct {
    double time, length, next, planned, grows, after_edge, after_kink, rough, last_half, power, lapse;
    double begin, stop, pieces, piece; /* of equal steps to a stop, in fixed.c */
    double node_time[2];
    long begun, first_run, sample, steps, rejected, at_edge, at_kink, known, split, leaps;
    double longest;
    long live[LANES], status[LANES], place[LANES], cursor[SETS][DRIVES + 1];
    column status_time, ripple, residual, put_in, lost, accounts[ACCOUNTS];
    column c[CONSTANTS], p[PARAMETERS + 1], state[SIZE + 1], owed[DRIVES + 1], seen[SEEN + 1];
    column rate[RATES + 1]; /* of the half step before the last */
    column low[JUDGED + 1], high[JUDGED + 1], scale[JUDGED + 1], limits[2 * ENVELOPE + 1];
    column points[NUMBERS + 1], earlier_points[NUMBERS + 1]; /* now, and half a step ago */
    /* start and middle of the last step, if there is no kink of a drive between them and now */
    column node_state[2][SIZE + 1], node_seen[2][JUDGED + 1];
    moments one[SETS][DRIVES + 1], two[SETS][DRIVES + 1];
    tone_angles angles[SETS][DRIVES + 1]; /* at the start of the step */
    column x0[SIZE + INPUTS + 1], x1[SIZE + INPUTS + 1], x2[SIZE + INPUTS + 1];
    column whole[SIZE + REPORTS], half[SIZE + 1], full[SIZE + 1], ends[ORDER == 4 ? 3 * SIZE : 1];
    column coarse[SEEN + 1], middle[SEEN + 1], fine[SEEN + 1], doubted[SEEN + 1], onset[SEEN + 1];
    column entries[ENTRIES + 1], middle_entries[ENTRIES + 1], last_entries[ENTRIES + 1];
    column points_half[NUMBERS + 1], points_full[NUMBERS + 1];
    column ripple_half[1], ripple_full[1], error, row[OUTPUTS + 1];
    column lowest[OUTPUTS + 1], highest[OUTPUTS + 1], sum[OUTPUTS + 1]; /* of totals.c */
    column last_middle[OUTPUTS + 1], last_row[OUTPUTS + 1];
} block;

typedef struct {
    long runs, samples, rounds, recording, parted, recorded, capacity;
    double tolerance, duration, step, shortest;
    const double *p;      /* parameters, (PARAMETERS, runs) */
    const double *first;  /* first step of each run */
    const double *times;  /* samples */
    const drive *drives;  /* (runs or 1, DRIVES) */
    const double *limits; /* low and high, (2, ENVELOPE, runs) */
    const double *ranges; /* (runs, JUDGED), of judged outputs, 0 where not known */
    double *rows;         /* (runs, samples, OUTPUTS) */
    double *numbers;      /* (runs, SAID + JUDGED): what is said of a run */
    double *record;       /* pieces of accepted steps: see martensite/simulate/track.py */
    double *states;       /* (runs, SIZE): where runs end, and begin if they are `placed` */
    double *extremes;     /* (runs, 2, JUDGED): lowest and highest of what is judged, before and then after */
    long placed;
    double *totals;       /* (runs, 3, OUTPUTS): lowest, highest and integral of outputs; none if nobody asks */
} march;

static void begin_totals(block *b, const column *row, const long long *begins);
static void tell_totals(const march *m, const block *b, long run, long i);

/* the drives of the runs in a block: one set, or one for every run */
static const drive *drives_of(const march *m, const block *b, long set) {
    const long run = b->first_run + set;
    return m->drives + (OWN ? (run < m->runs ? run : m->runs - 1) * DRIVES : 0);
}

/* whether all drives are known up to a time */
static int known_until(const march *m, const block *b, double time) {
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            const drive *d = drives_of(m, b, set) + i;
            if (!d->whole && !(d->start[d->count - 1] > time)) return 0;
        }
    return 1;
}

static void move_cursors(const march *m, block *b) {
    for (long set = 0; set < SETS; set++)
        for (long k = 0; k < DRIVES; k++)
            b->cursor[set][k] = segment_at(drives_of(m, b, set) + k, b->time, b->cursor[set][k]);
}

/* the inputs of a step */
static void feed(const moments (*found)[DRIVES + 1], const column *owed, double length, column *x) {
    for (long i = 0; i < DRIVES; i++) {
        const long wide = widths[i] > 1;
        EACH(k) {
            const moments *f = found[OWN ? k : 0] + i;
            x[0][k] = f->mean;
            if (!wide) continue;
            x[1][k] = f->square;
            x[2][k] = f->low;
            x[3][k] = f->high;
            x[4][k] = f->lapse;
            x[5][k] = f->slope;
            x[6][k] = f->square_slope;
            x[7][k] = owed ? owed[i][k] : 0.0;
        }
        x += widths[i];
    }
    EACH(k) x[0][k] = length;
}

/* what the drives bring in an interval */
static void bring(const march *m, const block *b, double begin, double end,
                  moments (*found)[DRIVES + 1]) {
    for (long set = 0; set < SETS; set++)
        for (long i = 0; i < DRIVES; i++) {
            const drive *d = drives_of(m, b, set) + i;
            if (widths[i] > 1) {
                const tone_angles at = angles_at(d, 0.5 * (begin + end));
                found[set][i] = moments_of(d, begin, end, b->cursor[set][i], &at);
            } else {
                found[set][i].mean = value_at(d, end, b->cursor[set][i], 1);
            }
        }
}

static void put_signals(const march *m, const block *b, double time, int before, column *x) {
    for (long i = 0; i < DRIVES; i++)
        for (long set = 0; set < SETS; set++) {
            const drive *d = drives_of(m, b, set) + i;
            const double value = value_at(d, time, b->cursor[set][i], before);
            if (OWN)
                x[i][set] = value;
            else
                EACH(k) x[i][k] = value;
        }
}

/* whether a step and the start of a run may not fit into the record */
static int is_full(const march *m) {
    return m->recording && m->recorded + 3 > m->capacity;
}

/* a piece of an accepted step, and the state at its end, in the layout of martensite/simulate/track.py */
static void record_piece(march *m, const block *b, double part, double begin, double end, const moments *brought,
                         const column *states) {
    if (!m->recording) return;
    double *row = m->record + m->recorded++ * RECORDED;
    *row++ = (double)b->first_run;
    *row++ = part;
    *row++ = begin;
    *row++ = end - begin;
    for (long i = 0; i < DRIVES; i++) {
        const drive *d = drives_of(m, b, 0) + i;
        const double after = level_at(d, begin, b->cursor[0][i], 0);
        *row++ = after;
        *row++ = part < 0.0 ? after : level_at(d, end, b->cursor[0][i], 1);
        const int wide = widths[i] > 1 && part >= 0.0;
        *row++ = wide ? brought[i].mean : after;
        *row++ = wide ? brought[i].square : after * after;
        *row++ = wide ? brought[i].low : after;
        *row++ = wide ? brought[i].high : after;
        *row++ = wide ? brought[i].lapse : 0.0;
    }
    for (long k = 0; k < SIZE; k++)
        if (observed[k]) *row++ = states[k][0];
}

static void judge_at(const march *m, block *b, const column *states, double time, int before,
                     column *seen) {
    memcpy(b->x2, states, sizeof(column) * SIZE);
    if (JUDGE_SIGNALS) put_signals(m, b, time, before, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *seen);
}

static void scale_ranges(const march *m, block *b) {
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const long run = b->first_run + i < m->runs ? b->first_run + i : m->runs - 1;
            const double known = m->ranges[run * JUDGED + k], range = b->high[k][i] - b->low[k][i];
            const double least = known > floors[k] ? known : floors[k];
            b->scale[k][i] = range > least ? range : least;
        }
}

static void tell(const march *m, const block *b, long i) {
    double *n = m->numbers + (b->first_run + i) * (SAID + JUDGED);
    n[0] = (double)b->status[i];
    n[1] = b->status[i] == LONG_STEP ? b->status_time[i] : b->time;
    n[2] = (double)b->place[i];
    n[3] = b->place[i] < 0 ? 0.0 : b->seen[JUDGED + b->place[i]][i];
    n[4] = (double)b->steps;
    n[5] = (double)b->rejected;
    n[6] = b->longest;
    n[7] = b->ripple[i];
    n[8] = b->residual[i];
    n[9] = b->put_in[i];
    n[10] = b->lost[i];
    for (long k = 0; k < ACCOUNTS; k++) n[11 + k] = b->accounts[k][i];
    double *ends = m->extremes + (b->first_run + i) * 2 * JUDGED;
    for (long k = 0; k < JUDGED; k++) {
        n[SAID + k] = b->high[k][i] - b->low[k][i];
        ends[k] = b->low[k][i];
        ends[JUDGED + k] = b->high[k][i];
    }
    for (long k = 0; k < SIZE; k++) m->states[(b->first_run + i) * SIZE + k] = b->state[k][i];
    tell_totals(m, b, b->first_run + i, i);
}

static int is_inside(const block *b, const column *seen, long k, long i) {
    return b->limits[k][i] <= seen[JUDGED + k][i] &&
           seen[JUDGED + k][i] <= b->limits[ENVELOPE + k][i];
}

static void check_envelope(block *b) {
    for (long k = 0; k < ENVELOPE; k++)
        LIVE(i) if (b->status[i] < UNSOLVED && !is_inside(b, b->seen, k, i)) {
            b->status[i] = isfinite(b->seen[JUDGED + k][i]) ? OUT_OF_ENVELOPE : NOT_FINITE;
            b->place[i] = k;
        }
}

/* runs that leave the envelope in this step, and are outside already in the states in x2 */
static void find_gone(const march *m, block *b, double time, long *gone) {
    long leaving = 0;
    for (long k = 0; k < ENVELOPE; k++) LIVE(i) leaving |= !is_inside(b, b->fine, k, i);
    EACH(i) gone[i] = 0;
    if (!leaving) return;
    column seen[SEEN + 1];
    if (JUDGE_SIGNALS) put_signals(m, b, time, 0, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *seen);
    for (long k = 0; k < ENVELOPE; k++) EACH(i) gone[i] |= !is_inside(b, seen, k, i);
}

/* runs that are done, or cannot go on */
static void end_runs(const march *m, block *b) {
    LIVE(i) if (b->status[i] >= UNSOLVED || !(b->time < m->duration)) {
        tell(m, b, i);
        b->live[i] = 0;
    }
}

static long any_live(const block *b) {
    long live = 0;
    if (b->begun) LIVE(i) live = 1;
    return live;
}

/* go to the end of a step, where this is judged */
static void see(const march *m, block *b, const column *seen) {
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            b->low[k][i] = seen[k][i] < b->low[k][i] ? seen[k][i] : b->low[k][i];
            b->high[k][i] = seen[k][i] > b->high[k][i] ? seen[k][i] : b->high[k][i];
        }
    memcpy(b->seen, seen, sizeof(column) * SEEN);
    scale_ranges(m, b);
    check_envelope(b);
}

/* outputs of the states in x2 at the next sample */
static void keep_rows(march *m, block *b, double time) {
    long gone[LANES];
    find_gone(m, b, time, gone);
    if (OBSERVE_SIGNALS) put_signals(m, b, time, 0, b->x2 + SIZE);
    k_observe(LANES, *b->c, *b->x2, *b->row);
    LIVE(i) if (!gone[i]) {
        double *row = m->rows + ((b->first_run + i) * m->samples + b->sample) * OUTPUTS;
        for (long k = 0; k < OUTPUTS; k++) row[k] = b->row[k][i];
    }
    b->sample++;
}

static void begin_block(march *m, block *b, long run) {
    memset(b, 0, sizeof *b);
    b->first_run = run;
    b->sample = b->at_edge = b->begun = 1;
    b->next = b->after_kink = HUGE_VAL;
    EACH(i) {
        const long own = run + i < m->runs ? run + i : m->runs - 1;
        b->live[i] = run + i < m->runs;
        b->place[i] = -1;
        if (m->first[own] < b->next) b->next = m->first[own];
        for (long k = 0; k < PARAMETERS; k++) b->p[k][i] = m->p[k * m->runs + own];
        for (long k = 0; k < 2 * ENVELOPE; k++) b->limits[k][i] = m->limits[k * m->runs + own];
    }
    b->after_edge = b->last_half = b->next;
    k_prepare(LANES, *b->p, *b->c);
    b->time = m->times[0];
    put_signals(m, b, b->time, 0, b->x0);
    if (!m->placed) k_init(LANES, *b->c, *b->x0, *b->state);
    for (long k = 0; m->placed && k < SIZE; k++)
        EACH(i) b->state[k][i] = m->states[(run + i < m->runs ? run + i : m->runs - 1) * SIZE + k];
    memcpy(b->x2, b->state, sizeof(column) * SIZE);
    put_signals(m, b, b->time, 0, b->x2 + SIZE);
    k_judge(LANES, *b->c, *b->x2, *b->seen);
    memcpy(b->low, b->seen, sizeof(column) * JUDGED);
    memcpy(b->high, b->seen, sizeof(column) * JUDGED);
    for (long k = 0; k < JUDGED; k++)
        EACH(i) {
            const double *ends = m->extremes + (run + i < m->runs ? run + i : m->runs - 1) * 2 * JUDGED;
            b->low[k][i] = ends[k] < b->low[k][i] ? ends[k] : b->low[k][i];
            b->high[k][i] = ends[JUDGED + k] > b->high[k][i] ? ends[JUDGED + k] : b->high[k][i];
        }
    scale_ranges(m, b);
    k_observe(LANES, *b->c, *b->x2, *b->row);
    LIVE(i) for (long k = 0; k < OUTPUTS; k++)
        m->rows[(run + i) * m->samples * OUTPUTS + k] = b->row[k][i];
    record_piece(m, b, -1.0, b->time, b->time, b->one[0], b->state);
    long long begins[LANES];
    EACH(i) begins[i] = 1;
    begin_totals(b, b->row, begins);
    check_envelope(b);
    end_runs(m, b);
}

long size_of_block(void) { return sizeof(block); }
double time_of(const block *b) { return b->time; }
long run_of(const block *b) { return b->begun ? b->first_run : 0; }

void forget_cursors(block *b) { memset(b->cursor, 0, sizeof b->cursor); }
