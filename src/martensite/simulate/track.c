/* Outputs of recorded states under signals: some rows of one run after those of another. Before this text stands
   marching.c with what it asks for. */

void observe_rows(long runs, const long *counts, const double *p, const double *x, double *y) {
    column own[PARAMETERS + 1], c[CONSTANTS], in[SIZE + DRIVES + 1], out[OUTPUTS + 1];
    long places[SIZE + DRIVES + 1], width = 0;
    for (long k = 0; k < SIZE + DRIVES; k++)
        if (k >= SIZE || observed[k]) places[width++] = k;
    memset(in, 0, sizeof in);
    for (long run = 0; run < runs; run++) {
        for (long k = 0; k < PARAMETERS; k++)
            for (long i = 0; i < LANES; i++) own[k][i] = p[k * runs + run];
        if (counts[run]) k_prepare(LANES, *own, *c);
        for (long first = 0; first < counts[run]; first += LANES) {
            const long left = counts[run] - first, rows = left < LANES ? left : LANES;
            for (long i = 0; i < LANES; i++)
                for (long k = 0; k < width; k++) in[places[k]][i] = x[(i < rows ? i : rows - 1) * width + k];
            k_observe(LANES, *c, *in, *out);
            for (long i = 0; i < rows; i++)
                for (long k = 0; k < OUTPUTS; k++) y[i * OUTPUTS + k] = out[k][i];
            x += rows * width;
            y += rows * OUTPUTS;
        }
    }
}
