/* One run on given steps with the derivatives of its outputs, on kernels that stand before this text. */

void march(long intervals, const double *restrict p, const slopes *restrict dp,
           const double *restrict first, const double *restrict sampled,
           const long *restrict counts, const double *restrict drives,
           const double *restrict lengths, double *restrict rows, slopes *restrict drows,
           double *restrict worst) {
    double c[CONSTANTS], x[SIZE + INPUTS + 1], y[RESULTS];
    slopes dc[CONSTANT_SLOPES], dx[SIZE], dy[RESULTS];
    k_prepare(p, dp, c, dc);
    for (long j = 0; j < REPORTS; j++) worst[j] = 0.0;
    memcpy(x, first, sizeof(double) * DRIVES);
    k_init(c, dc, x, dx, y, dy);
    memcpy(x, y, sizeof(double) * SIZE);
    memcpy(dx, dy, sizeof(slopes) * SIZE);
    memcpy(x + SIZE, first, sizeof(double) * DRIVES);
    k_observe(c, dc, x, dx, rows, drows);
    for (long i = 0; i < intervals; i++) {
        for (long k = 0; k < counts[i]; k++, drives += INPUTS, lengths++) {
            memcpy(x + SIZE, drives, sizeof(double) * INPUTS);
            x[SIZE + INPUTS] = *lengths;
            k_step(c, dc, x, dx, y, dy);
            memcpy(x, y, sizeof(double) * SIZE);
            memcpy(dx, dy, sizeof(slopes) * SIZE);
            for (long j = 0; j < REPORTS; j++)
                worst[j] = worst[j] >= y[SIZE + j] ? worst[j] : y[SIZE + j];
        }
        memcpy(x + SIZE, sampled + i * DRIVES, sizeof(double) * DRIVES);
        rows += OUTPUTS;
        drows += OUTPUTS;
        k_observe(c, dc, x, dx, rows, drows);
    }
}
