/* A material point along one leg of its path, on the kernel STEP that stands before this text. */

void ride(long samples, long finer, const double *restrict c, const double *restrict ramp,
          double *restrict memory, double *restrict rows, double *restrict worst,
          long *restrict where) {
    double x[INPUTS], y[RESULTS];
    const long n = samples * finer;
    memcpy(x, memory, sizeof(double) * SIZE);
    worst[0] = 0.0;
    where[0] = 0;
    for (long k = 1; k <= n; k++) {
        const double share = (double)k / (double)n;
        x[SIZE] = k == n ? ramp[1] : ramp[0] + share * (ramp[1] - ramp[0]);
        x[SIZE + 1] = k == n ? ramp[3] : ramp[2] + share * (ramp[3] - ramp[2]);
        x[SIZE + 2] = ramp[4];
        STEP(1, c, x, y);
        memcpy(x, y, sizeof(double) * SIZE);
        if (!(y[RESULTS - 1] <= worst[0])) { worst[0] = y[RESULTS - 1]; where[0] = k - 1; }
        if (k % finer == 0) {
            memcpy(rows, y + SIZE, sizeof(double) * ROW);
            rows += ROW;
        }
    }
    memcpy(memory, x, sizeof(double) * SIZE);
}
