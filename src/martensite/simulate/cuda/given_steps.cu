/* The march on given steps on a GPU, one run a thread: the same march as martensite/simulate/given_steps.c.

   Before this text stand the functions k_prepare (what follows from parameters that are the same for all runs),
   k_own (from those that vary), k_init, k_step, k_observe and k_judge, the type `number`, and sizes: COMMON and OWN
   of what they prepare, VARIED parameters, SIZE states, DRIVES signals, INPUTS of a step, OUTPUTS wanted, ENVELOPE;
   whether every run has signals and steps of its own (OWN_STEPS) and limits of its own (OWN_LIMITS).

   Neighbours in a warp are neighbours in memory: all arrays are [variable][run]. What is the same for all runs lies
   in constant memory; a state, and what follows from varied parameters, stays in registers. */

#define RUN ((long long)blockIdx.x * blockDim.x + threadIdx.x)
#define AT(array, row) array[(long long)(row) * stride + run]
#define SIGNAL(array, row) (OWN_STEPS ? AT(array, row) : array[row])

static __constant__ int places[DRIVES + 1] = PLACES;

/* one thread: what all runs have in common, from all parameters */
KERNEL prepare(const number *__restrict__ p, number *__restrict__ made) { k_prepare(p, made); }

KERNEL march(long long runs, int intervals, const number *__restrict__ varied, const number *__restrict__ first,
             const number *__restrict__ sampled, const int *__restrict__ counts, const number *__restrict__ drives,
             const number *__restrict__ lengths, const number *__restrict__ limits, number *__restrict__ rows,
             number *__restrict__ worst, double *__restrict__ left) {
    const long long run = RUN, stride = runs;
    number c[OWN + 1], x[SIZE + INPUTS + 1], y[SIZE + REPORTS], signals[DRIVES + 1], seen[ENVELOPE + 1];
    number own[VARIED + 1], out[OUTPUTS], reports[REPORTS];
    double now = 0.0, gone = HUGE_VAL;
    long long step = 0;
    if (run >= runs) return;
    for (int k = 0; k < VARIED; k++) own[k] = AT(varied, k);
    k_own(own, c);
    for (int d = 0; d < DRIVES; d++) signals[d] = SIGNAL(first, d);
    k_init(c, x, signals, x);
    k_observe(c, x, signals, out);
    for (int k = 0; k < OUTPUTS; k++) AT(rows, k) = out[k];
    for (int k = 0; k < REPORTS; k++) reports[k] = 0;
    for (int i = 0; i < intervals; i++) {
        const int count = counts[i];
        for (int j = 0; j < count; j++, step++) {
            const number length = SIGNAL(lengths, step);
            if (OWN_STEPS && !(length > 0)) continue; /* a step of no length keeps the state */
            for (int d = 0; d < INPUTS; d++) x[SIZE + d] = SIGNAL(drives, step * INPUTS + d);
            x[SIZE + INPUTS] = length;
            k_step(c, x, x + SIZE, y);
            for (int k = 0; k < SIZE; k++) x[k] = y[k];
            for (int k = 0; k < REPORTS; k++)
                reports[k] = reports[k] >= y[SIZE + k] || gone < HUGE_VAL ? reports[k] : y[SIZE + k];
            now += (double)length;
            if (ENVELOPE) {
                for (int d = 0; d < DRIVES; d++) signals[d] = x[SIZE + places[d]];
                k_judge(c, x, signals, seen);
                for (int k = 0; k < ENVELOPE; k++) {
                    const number low = OWN_LIMITS ? AT(limits, k) : limits[k];
                    const number high = OWN_LIMITS ? AT(limits, ENVELOPE + k) : limits[ENVELOPE + k];
                    const int out_of = isfinite(seen[k]) && !(low <= seen[k] && seen[k] <= high);
                    if (out_of && gone == HUGE_VAL) gone = now;
                }
            }
        }
        for (int d = 0; d < DRIVES; d++) signals[d] = SIGNAL(sampled, i * DRIVES + d);
        k_observe(c, x, signals, out);
        for (int k = 0; k < OUTPUTS; k++) AT(rows, (long long)(i + 1) * OUTPUTS + k) = out[k];
    }
    for (int k = 0; k < REPORTS; k++) AT(worst, k) = reports[k];
    left[run] = gone;
}
