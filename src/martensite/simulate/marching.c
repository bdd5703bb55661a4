/* The march of runs in C: of a batch, LANES runs side by side, and of one run, which is a batch of one lane.
   Each run has separate steps, and changes no bit of the others. A lane whose run has ended takes the next run.
   What is done, and why, is said in martensite/simulate/adaptive.py and march.py.

   A march consists of this text, drives.c, totals.c, runs.c, and then either fixed.c, or ledger.c (if there is a
   LEDGER), surface.c, lengths.c, kinks.c, samples.c, forks.c and adaptive.c. Before this text stand
   martensite/signals/reader.c and the
   kernels k_prepare, k_init, k_observe and k_judge over LANES lanes, and: SIMD, which begins loops that compilers
   turn into vectors; SIZE states, DRIVES signals, INPUTS of a step, OUTPUTS wanted, JUDGED, ENVELOPE, HEATED,
   CONSTANTS, PARAMETERS; WIDTHS (inputs of each drive) and LEAST (range of each judged output that counts); OWN if
   every run has separate drives; whether k_judge and k_observe ask for signals; how many numbers a piece of a step
   is RECORDED by; which states are OBSERVED; POINTS, all their NUMBERS, FORKS and RATES of adaptive.c; ENTRIES and
   ACCOUNTS of ledger.c.

   Loops over lanes are written so that a compiler makes vectors of them: values are chosen, not branched upon,
   except where few lanes have something to do. */

#define SEEN (JUDGED + ENVELOPE + HEATED)
#define DECIDED 5 /* margin, time, change, place and branch of the closest decision: forks.py */
#define SAID (11 + ACCOUNTS + DECIDED)
#define REPORTS 3
#define ANSWERS (ORDER == 4 ? 3 * SIZE : SIZE + REPORTS)
#define STATES (ORDER == 5 ? 6 * SIZE + 17 : ORDER == 4 ? 3 * SIZE : 1) /* of one step of higher order */
#define MOMENTS 7
#define IDLE 2 /* number of lanes without a run at which runs begin */
#ifndef INLINE /* vectors.c defines it for a batch */
#define INLINE static inline
#endif
#define EVERY(i) for (long i = 0; i < LANES; i++)
#define EACH(i) SIMD EVERY(i)
/* SOME: the lanes of a set of bits, one after another */
#if LANES > 1
#define SOME(i, bits) \
    for (long long left_ = (long long)(bits), i; left_ && (i = __builtin_ctzll(left_), 1); left_ &= left_ - 1)
#else
#define SOME(i, bits) for (long i = 0; i < (long)(bits); i++)
#endif
#define BLEND(to, mask, from) EACH(i_) (to)[i_] = (mask)[i_] ? (from)[i_] : (to)[i_]

enum { OK = 0, LONG_STEP = 1, UNSOLVED = 2, NOT_FINITE = 4, OUT_OF_ENVELOPE = 7 };
enum { DONE = 0, PAUSED = 1, SIGNALS = 2, RECORD = 3 };
enum { MEAN, SQUARE, LOW, HIGH, LAPSE, SLOPE, SQUARE_SLOPE };

static const long widths[DRIVES + 1] = WIDTHS;
static const double floors[JUDGED + 1] = LEAST;
static const long observed[SIZE + 1] = OBSERVED; /* whether outputs depend on a state */

typedef double column[LANES];
typedef long long flags_of_lanes[LANES]; /* as wide as numbers */

/* The segment of a drive in which steps begin, when the next one starts, and the tones, with their angles where steps
   begin. Where steps end the angles are turned from there, if `ready`, up to so many `turns` in a row. */
typedef struct {
    flags_of_lanes run, cursor, ready, turns;
    column start, level, slope, bend, following;
    column amplitude[TONES + 1], speed[TONES + 1], phase[TONES + 1], cosine[TONES + 1], sine[TONES + 1];
    column last_cosine[TONES + 1], last_sine[TONES + 1];
} drives_of_lanes;

/* steps to samples that no polynomial reaches; they are made when they fill all lanes */
typedef struct {
    long count;
    flags_of_lanes run, sample, leaving;
    column begin, end, c[CONSTANTS], x[SIZE + INPUTS + 1], y[ANSWERS], row[OUTPUTS + 1];
    column owed[DRIVES + 1], line[SIZE + 1]; /* states on a straight line, if the step is not solved */
    drives_of_lanes then[DRIVES + 1];
} steps_aside;

/* the runs in the lanes: where they are, and the step that each tries */
typedef struct {
    long next_run, end_run, done; /* runs from next_run to before end_run have not begun */
    flags_of_lanes run, live, loaded, fresh, sample, status, place, at_edge, at_kink, known, split, leaps;
    column time, length, next, planned, grows, after_edge, after_kink, rough, last_half, power, lapse;
    column coming; /* time of the next sample */
    column steps, rejected, longest, ripple, residual, error, kink;
    column p[PARAMETERS + 1], c[CONSTANTS], state[SIZE + 1], owed[DRIVES + 1], seen[SEEN + 1];
    column rate[RATES + 1]; /* of the half step before the last */
    flags_of_lanes cut;        /* whether the trial before was cut at a kink */
    flags_of_lanes on_surface; /* whether the step is one of order five */
    flags_of_lanes accurate;   /* whether its temperature is, and places of kinks are therefore reliable */
    column decay;              /* rate of the heat balance [1/s] */
    column between, event_begin[NUMBERS + 1], event_between[NUMBERS + 1], event_end[NUMBERS + 1]; /* of surface.c */
    long begun; /* whether event_begin is known */
    double phase; /* largest phase of a tone in a step of order five */
    column low[JUDGED + 1], high[JUDGED + 1], scale[JUDGED + 1], range[JUDGED + 1];
    column limits[2 * ENVELOPE + 1];
    column points[NUMBERS + 1], earlier_points[NUMBERS + 1]; /* now, and half a step ago */
    column put_in, lost, accounts[ACCOUNTS], entries[ENTRIES + 1]; /* of ledger.c */
    column watched[FORKS + 1][17], decided[DECIDED]; /* of forks.c */
    column status_time; /* of fixed.c, with the equal steps to a stop */
    double begin, stop, pieces, piece;
    /* start and middle of the last step, if there is no kink of a drive between them and now */
    column node_time[2], node_state[2][SIZE + 1], node_seen[2][JUDGED + 1];
    column older_time, older_seen[JUDGED + 1]; /* half a step before these, if `known` is 2 */
    column owed_before[DRIVES + 1];            /* in the last step */
    drives_of_lanes now[DRIVES + 1];
    column one[DRIVES + 1][MOMENTS], two[DRIVES + 1][MOMENTS];
    column x0[SIZE + (ORDER == 5 ? 2 : 1) * INPUTS + 1], x1[SIZE + INPUTS + 1], x2[SIZE + INPUTS + 1];
    column whole[SIZE + REPORTS], half[SIZE + REPORTS], full[SIZE + REPORTS];
    column ends[STATES], doubted[SEEN + 1], onset[SEEN + 1];
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
    double *states;       /* (runs, SIZE): where runs end, and begin if they are `placed` */
    double *extremes;     /* (runs, 2, JUDGED): lowest and highest of what is judged, before and then after */
    long placed;
    double *totals;       /* (runs, 3, OUTPUTS): lowest, highest and integral of outputs; none if nobody asks */
} march;

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

/* whether a flag is set; compilers make vectors of this loop */
INLINE int any(const flags_of_lanes flags) {
    long long found = 0;
    EVERY(i) found |= flags[i];
    return found != 0;
}

/* the lanes whose flags are set, as bits */
INLINE unsigned long long bits_of(const flags_of_lanes flags) {
    unsigned long long found = 0;
    if (!any(flags)) return 0;
    EVERY(i) found |= (unsigned long long)(flags[i] != 0) << i;
    return found;
}
