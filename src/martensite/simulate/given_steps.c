/* The march on given steps, one run or many in lanes, on kernels that stand before this text: k_prepare, k_init,
   k_step, k_observe, and k_judge where it is BOUNDED by an envelope. With OWN signals and steps every lane
   has those of a LaneGrid, where a step of no length keeps the state. */

#define EACH (OWN ? LANES : 1)
#define SIGNAL(d) (OWN ? (d) * LANES + l : (d))

void march(long lanes, long intervals, const double *restrict p, const double *restrict first,
           const double *restrict sampled, const long *restrict counts,
           const double *restrict drives, const double *restrict lengths,
           double *restrict rows, double *restrict worst, const double *restrict limits,
           double *restrict left, double *restrict states) {
    double c[CONSTANTS * LANES], x[(SIZE + INPUTS + 1) * LANES], y[RESULTS * LANES];
    const long n = LANES;
#if BOUNDED
    double now[LANES] = {0.0}, z[(SIZE + DRIVES) * LANES], seen[SEEN * LANES];
    static const long places[] = PLACES;
#endif
    k_prepare(n, p, c);
    for (long l = 0; l < n; l++) {
        for (long d = 0; d < DRIVES; d++) x[d * n + l] = first[SIGNAL(d)];
        for (long k = 0; k < REPORTS; k++) worst[k * n + l] = 0.0;
        left[l] = HUGE_VAL;
    }
    k_init(n, c, x, y);
    memcpy(x, isnan(states[0]) ? y : states, sizeof(double) * SIZE * n);
    for (long d = 0; d < DRIVES; d++)
        for (long l = 0; l < n; l++) x[(SIZE + d) * n + l] = first[SIGNAL(d)];
    k_observe(n, c, x, rows);
    for (long i = 0; i < intervals; i++) {
        for (long k = 0; k < counts[i]; k++, drives += INPUTS * EACH, lengths += EACH) {
            for (long l = 0; l < n; l++) {
                for (long d = 0; d < INPUTS; d++) x[(SIZE + d) * n + l] = drives[SIGNAL(d)];
                x[(SIZE + INPUTS) * n + l] = lengths[OWN ? l : 0];
            }
            k_step(n, c, x, y);
#if OWN
            for (long l = 0; l < n; l++) if (!(lengths[l] > 0.0)) {
                for (long k = 0; k < SIZE; k++) y[k * n + l] = x[k * n + l];
                for (long k = 0; k < REPORTS; k++) y[(SIZE + k) * n + l] = 0.0;
            }
#endif
            memcpy(x, y, sizeof(double) * SIZE * n);
            for (long k = 0; k < REPORTS; k++)
                for (long l = 0; l < n; l++) {
                    const double a = worst[k * n + l], b = y[(SIZE + k) * n + l];
                    worst[k * n + l] = a >= b || left[l] < HUGE_VAL ? a : b;
                }
#if BOUNDED
            for (long l = 0; l < n; l++) now[l] += lengths[OWN ? l : 0];
            memcpy(z, y, sizeof(double) * SIZE * n);
            for (long d = 0; d < DRIVES; d++)
                memcpy(z + (SIZE + d) * n, x + (SIZE + places[d]) * n, sizeof(double) * n);
            k_judge(n, c, z, seen);
            for (long k = 0; k < ENVELOPE; k++)
                for (long l = 0; l < n; l++) {
                    const double v = seen[(JUDGED + k) * n + l];
                    const int out = isfinite(v) && !(limits[k * n + l] <= v &&
                                                     v <= limits[(ENVELOPE + k) * n + l]);
                    if (out && left[l] == HUGE_VAL) left[l] = now[l];
                }
#endif
        }
        for (long d = 0; d < DRIVES; d++)
            for (long l = 0; l < n; l++) x[(SIZE + d) * n + l] = sampled[SIGNAL(d)];
        sampled += DRIVES * EACH;
        rows += OUTPUTS * n;
        k_observe(n, c, x, rows);
    }
    memcpy(states, x, sizeof(double) * SIZE * n);
}
