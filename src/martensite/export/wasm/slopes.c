/* Slopes: the lanes with derivatives of their states in several directions, in groups of WIDTH. A direction
   is a parameter, or a signal that is moved from the start on. Before this text stand the lanes. */

enum {
    STATES = CORE(STATES),
    MOVED = STATES + CORE(INPUTS),
    SHOWN = CORE(OUTPUTS)
};

typedef struct {
    double c[VALUES];
} prepared;

typedef struct {
    slopes c[VALUE_SLOPES], x[MOVED + 1], next[STATES + 1], y[SHOWN + 1];
} tangent;

/* The slope of an output in a direction. */
static double pick(const tangent *t, int output, int d) { return ((const double *)&t[d / WIDTH].y[output])[d % WIDTH]; }

static int finite_slopes(const tangent *t, int groups)
{
    for (int g = 0; g < groups; g++)
        if (!CORE(finite)((const double *)t[g].next, STATES * WIDTH)) return 0;
    return 1;
}

static void keep_slopes(tangent *t, int groups)
{
    for (int g = 0; g < groups; g++)
        for (int i = 0; i < STATES; i++) t[g].x[i] = t[g].next[i];
}

static int step_with_slopes(model *m, const double *u, double dt, const prepared *v, tangent *t, int groups);

/* After parameters have changed, or at the beginning: `wanted` are the places of the directions. */
EXPORT(slopes_prepare) void slopes_prepare(const model *m, int lanes, int count, const int *wanted, prepared *v,
                                           tangent *t)
{
    const int groups = (count + WIDTH - 1) / WIDTH;
    for (int lane = 0; lane < lanes; lane++, t += groups)
        for (int g = 0; g < groups; g++) {
            slopes dp[MOVING + 1];
            for (int i = 0; i < MOVING; i++) dp[i] = ZERO;
            for (int i = STATES; i < MOVED; i++) t[g].x[i] = ZERO;
            for (int k = 0; k < WIDTH && g * WIDTH + k < count; k++) {
                const int place = wanted[g * WIDTH + k];
                ((double *)(place < MOVING ? dp + place : t[g].x + STATES + place - MOVING))[k] = 1.0;
            }
            slopes_of_prepare(m[lane].p, dp, v[lane].c, t[g].c);
        }
}

EXPORT(slopes_start) void slopes_start(model *m, int lanes, const double *signals, int *status, int groups,
                                       const prepared *v, tangent *t)
{
    double u[CORE(INPUTS) + 1], y[STATES + 1];
    for (int lane = 0; lane < lanes; lane++, t += groups) {
        gather(signals, lanes, lane, CORE(INPUTS), u);
        status[lane] = CORE(BAD_INPUT);
        if (!CORE(finite)(u, CORE(INPUTS))) continue;
        for (int g = 0; g < groups; g++)
            slopes_of_init(v[lane].c, t[g].c, m[lane].x, t[g].x + STATES, u, 0.0, y, t[g].next);
        status[lane] = finite_slopes(t, groups) ? CORE(start)(m + lane, u) : CORE(NOT_FINITE);
        if (status[lane] <= COARSE) keep_slopes(t, groups);
    }
}

EXPORT(slopes_step) void slopes_step(model *m, int lanes, const double *signals, double dt, int *status, int groups,
                                     const prepared *v, tangent *t)
{
    double u[CORE(INPUTS) + 1];
    for (int lane = 0; lane < lanes; lane++, t += groups) {
        gather(signals, lanes, lane, CORE(INPUTS), u);
        status[lane] = step_with_slopes(m + lane, u, dt, v + lane, t, groups);
    }
}

/* Outputs y, and their slopes in t. */
static int see(const model *m, const double *u, double *y, const prepared *v, tangent *t, int groups)
{
    double same[SHOWN + 1];
    for (int g = 0; g < groups; g++) slopes_of_observe(v->c, t[g].c, m->x, t[g].x, u, 0.0, same, t[g].y);
    return CORE(observe)(m, u, y);
}

/* Slopes seen[output][direction][lane]; one that is infinite stays so. */
EXPORT(slopes_observe) void slopes_observe(const model *m, int lanes, const double *signals, double *seen,
                                           int *status, int count, const prepared *v, tangent *t)
{
    const int groups = (count + WIDTH - 1) / WIDTH;
    double u[CORE(INPUTS) + 1], y[SHOWN + 1];
    for (int lane = 0; lane < lanes; lane++, t += groups) {
        gather(signals, lanes, lane, CORE(INPUTS), u);
        status[lane] = see(m + lane, u, y, v + lane, t, groups);
        for (int i = 0; i < SHOWN * count; i++)
            seen[i * lanes + lane] =
                status[lane] > COARSE ? __builtin_nan("") : pick(t, i / count, i % count);
    }
}

/* As `run`, with slopes rows_slopes[row][output][direction][lane] beside the rows. */
EXPORT(slopes_run) void slopes_run(model *m, int lanes, int steps, const double *dt, const double *signals, int every,
                                   int chosen, const int *outputs, double *rows, int *status, int *taken, int count,
                                   const prepared *v, tangent *t, double *rows_slopes)
{
    const int groups = (count + WIDTH - 1) / WIDTH;
    double u[CORE(INPUTS) + 1], y[SHOWN + 1];
    for (int lane = 0; lane < lanes; lane++, t += groups) {
        double *row = rows + lane, *slope = rows_slopes + lane;
        status[lane] = DONE;
        taken[lane] = 0;
        for (int k = 0; k < steps; k++) {
            int found = status[lane];
            if (status[lane] <= COARSE) {
                gather(signals + (long)k * CORE(INPUTS) * lanes, lanes, lane, CORE(INPUTS), u);
                found = step_with_slopes(m + lane, u, dt[k], v + lane, t, groups);
                if (found > status[lane]) status[lane] = found;
                if (found <= COARSE) taken[lane]++;
            }
            if ((k + 1) % every && k + 1 < steps) continue;
            if (status[lane] <= COARSE) {
                found = see(m + lane, u, y, v + lane, t, groups);
                for (int i = 0; i < chosen * count; i++)
                    if (!(fabs(pick(t, outputs[i / count], i % count)) <= DBL_MAX)) found = CORE(NOT_FINITE);
                if (found > status[lane]) status[lane] = found;
            }
            for (int i = 0; i < chosen; i++, row += lanes) {
                *row = status[lane] > COARSE ? __builtin_nan("") : y[outputs[i]];
                for (int d = 0; d < count; d++, slope += lanes)
                    *slope = status[lane] > COARSE ? __builtin_nan("") : pick(t, outputs[i], d);
            }
        }
    }
}
