/* One stretch of steps from a state that is given, with the derivatives of the state at its end in all directions,
   on kernels that stand before this text. `states` takes the state before every step and after the last. */

void march_stretch(long steps, const double *restrict p, const slopes *restrict dp, const double *restrict first,
                   const slopes *restrict dfirst, const double *restrict given, const slopes *restrict dgiven,
                   double *restrict states, slopes *restrict dlast, double *restrict worst) {
    double c[CONSTANTS], x[INPUTS], y[RESULTS];
    slopes dc[CONSTANT_SLOPES], dx[INPUTS], dy[RESULTS];
    k_prepare(p, dp, c, dc);
    for (long j = 0; j < REPORTS; j++) worst[j] = 0.0;
    memcpy(x, first, sizeof(double) * SIZE);
    memcpy(dx, dfirst, sizeof(slopes) * SIZE);
    memcpy(states, x, sizeof(double) * SIZE);
    for (long i = 0; i < steps; i++, given += INPUTS - SIZE, dgiven += INPUTS - SIZE) {
        memcpy(x + SIZE, given, sizeof(double) * (INPUTS - SIZE));
        memcpy(dx + SIZE, dgiven, sizeof(slopes) * (INPUTS - SIZE));
        k_step(c, dc, x, dx, y, dy);
        memcpy(x, y, sizeof(double) * SIZE);
        memcpy(dx, dy, sizeof(slopes) * SIZE);
        states += SIZE;
        memcpy(states, x, sizeof(double) * SIZE);
        for (long j = 0; j < REPORTS; j++) worst[j] = worst[j] >= y[SIZE + j] ? worst[j] : y[SIZE + j];
    }
    memcpy(dlast, dx, sizeof(slopes) * SIZE);
}

void observe_states(long count, const double *restrict p, const slopes *restrict dp, const double *restrict states,
                    const double *restrict signals, double *restrict rows) {
    double c[CONSTANTS], x[SIZE + DRIVES], y[OUTPUTS];
    slopes dc[CONSTANT_SLOPES], dx[SIZE + DRIVES], dy[OUTPUTS];
    k_prepare(p, dp, c, dc);
    memset(dx, 0, sizeof(dx));
    for (long i = 0; i < count; i++, states += SIZE, signals += DRIVES, rows += OUTPUTS) {
        memcpy(x, states, sizeof(double) * SIZE);
        memcpy(x + SIZE, signals, sizeof(double) * DRIVES);
        k_observe(c, dc, x, dx, y, dy);
        memcpy(rows, y, sizeof(double) * OUTPUTS);
    }
}

void observe_slopes(const double *restrict p, const slopes *restrict dp, const double *restrict state,
                    const double *restrict signals, const slopes *restrict dstate, slopes *restrict drows) {
    double c[CONSTANTS], x[SIZE + DRIVES], y[OUTPUTS];
    slopes dc[CONSTANT_SLOPES], dx[SIZE + DRIVES];
    k_prepare(p, dp, c, dc);
    memset(dx, 0, sizeof(dx));
    memcpy(x, state, sizeof(double) * SIZE);
    memcpy(x + SIZE, signals, sizeof(double) * DRIVES);
    memcpy(dx, dstate, sizeof(slopes) * SIZE);
    k_observe(c, dc, x, dx, y, drows);
}
