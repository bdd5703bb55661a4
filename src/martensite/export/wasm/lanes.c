/* Lanes: equal models beside each other, one run each. Arrays are laid out [variable][lane]. A lane
   that fails keeps its state, and the others go on. Before this text stands the core. */

#ifdef __wasm__
#define EXPORT(name) __attribute__((export_name(#name)))
#else
#define EXPORT(name)
#endif

typedef CORE(model) model;

enum { DONE = CORE(OK), COARSE = CORE(LONG_STEP) };

static void gather(const double *all, int lanes, int lane, int count, double *one)
{
    for (int k = 0; k < count; k++) one[k] = all[k * lanes + lane];
}

EXPORT(defaults) void defaults(model *m, int lanes)
{
    for (int lane = 0; lane < lanes; lane++) CORE(defaults)(m + lane);
}

EXPORT(prepare) void prepare(model *m, int lanes, int *status)
{
    for (int lane = 0; lane < lanes; lane++) status[lane] = CORE(prepare)(m + lane);
}

EXPORT(start) void start(model *m, int lanes, const double *signals, int *status)
{
    double u[CORE(INPUTS) + 1];
    for (int lane = 0; lane < lanes; lane++) {
        gather(signals, lanes, lane, CORE(INPUTS), u);
        status[lane] = CORE(start)(m + lane, u);
    }
}

EXPORT(step) void step(model *m, int lanes, const double *signals, double dt, int *status)
{
    double u[CORE(INPUTS) + 1];
    for (int lane = 0; lane < lanes; lane++) {
        gather(signals, lanes, lane, CORE(INPUTS), u);
        status[lane] = CORE(step)(m + lane, u, dt);
    }
}

EXPORT(observe) void observe(const model *m, int lanes, const double *signals, double *seen, int *status)
{
    double u[CORE(INPUTS) + 1], y[CORE(OUTPUTS) + 1];
    for (int lane = 0; lane < lanes; lane++) {
        gather(signals, lanes, lane, CORE(INPUTS), u);
        status[lane] = CORE(observe)(m + lane, u, y);
        for (int k = 0; k < CORE(OUTPUTS); k++)
            seen[k * lanes + lane] = status[lane] > COARSE ? __builtin_nan("") : y[k];
    }
}

/* Steps of dt[step] under signals[step][input][lane]; after every `every`th step, and at the end, a row
   of the chosen outputs, rows[row][output][lane]. `taken` counts the steps of a lane. One that fails
   stops, with its worst status; its rows are no numbers from there on. */
EXPORT(run) void run(model *m, int lanes, int steps, const double *dt, const double *signals, int every,
                     int chosen, const int *outputs, double *rows, int *status, int *taken)
{
    double u[CORE(INPUTS) + 1], y[CORE(OUTPUTS) + 1];
    for (int lane = 0; lane < lanes; lane++) {
        double *row = rows + lane;
        status[lane] = DONE;
        taken[lane] = 0;
        for (int k = 0; k < steps; k++) {
            if (status[lane] <= COARSE) {
                gather(signals + (long)k * CORE(INPUTS) * lanes, lanes, lane, CORE(INPUTS), u);
                const int found = CORE(step)(m + lane, u, dt[k]);
                if (found > status[lane]) status[lane] = found;
                if (found <= COARSE) taken[lane]++;
            }
            if ((k + 1) % every && k + 1 < steps) continue;
            if (status[lane] <= COARSE) {
                const int found = CORE(observe)(m + lane, u, y);
                if (found > status[lane]) status[lane] = found;
            }
            for (int i = 0; i < chosen; i++, row += lanes)
                *row = status[lane] > COARSE ? __builtin_nan("") : y[outputs[i]];
        }
    }
}
