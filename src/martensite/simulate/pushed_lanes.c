/* Lanes taken forward from outside, on the kernels k_step and k_observe that stand before this text. */

void advance(long n, long steps, const double *restrict c, double *restrict x,
             double *restrict y, double *restrict worst,
             const double *restrict drives, double *restrict rows) {
    for (long i = 0; i < steps; i++) {
        memcpy(x + SIZE * n, drives, sizeof(double) * DRIVES * n);
        k_step(n, c, x, y);
        memcpy(x, y, sizeof(double) * SIZE * n);
        for (long l = 0; l < n; l++) {
            const double r = y[SIZE * n + l], s = y[(SIZE + 1) * n + l];
            if (!(r <= worst[l]) && worst[l] == worst[l]) worst[l] = r;
            if (!(s <= worst[n + l]) && worst[n + l] == worst[n + l]) worst[n + l] = s;
        }
        if (rows) {
            k_observe(n, c, x, rows);
            rows += OUTPUTS * n;
        }
        drives += DRIVES * n;
    }
}
