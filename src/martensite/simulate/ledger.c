/* The ledgers of one run, as in martensite/simulate/ledger.py. A batch keeps none.

   Before this text stand runs.c with what it asks for, the kernels k_entries and k_flows, and: HELD energies and
   EFFORTS of k_entries, BALANCED if it ends with a loss;
   FLOWS numbers of k_flows, what comes in and, if a signal lets it out, what is lost;
   ACCOUNT_OF all of them, STORE_OF each energy what it is to what is exchanged, TURNED_OVER of each effort
   whether it is, ENTRY_SIGNALS whether k_entries asks for signals. */

static const long account_of[HELD + EFFORTS + 1] = ACCOUNT_OF;
static const long store_of[HELD + 1] = STORE_OF;
static const long turned_over[EFFORTS + 1] = TURNED_OVER;

static void enter_at(const march *m, block *b, const column *states, const column time, int before, column *entries) {
    memcpy(b->x2, states, sizeof(column) * SIZE);
    if (ENTRY_SIGNALS) put_signals(m, b, time, before, b->x2 + SIZE);
    k_entries(LANES, *b->c, *b->x2, *entries);
}

static void begin_ledger(const march *m, block *b) {
    if (ENTRIES) enter_at(m, b, b->state, b->time, 0, b->entries);
}

/* a part of what came in in a step, and of what a signal let out, from what drives bring at a state */
static void add_flows(block *b, const column *states, const column (*found)[MOMENTS], double part, double let_out) {
    column flow[2];
    memcpy(b->x2, states, sizeof(column) * SIZE);
    feed(found, 0, b->length, b->x2 + SIZE);
    k_flows(LANES, *b->c, *b->x2, *flow);
    EACH(i) b->put_in[i] += part * b->length[i] * flow[0][i];
    if (FLOWS > 1) EACH(i) b->lost[i] += let_out * b->length[i] * flow[1][i];
}

/* the work of an effort in the step, all three numbers of both on parabolas */
static void add_work(block *b, long k, const column *middle, const column *last, column given) {
    const long at = HELD + 2 * k;
    const column *f = b->entries + at, *g = middle + at, *h = last + at;
    EACH(i) {
        const double half = 4.0 * (g[1][i] - f[1][i]), whole = h[1][i] - f[1][i];
        const double sum = f[0][i] * (half - whole) + 4.0 * g[0][i] * whole + h[0][i] * (3.0 * whole - half);
        const double work = sum * (1.0 / 6.0);
        b->accounts[account_of[HELD + k]][i] += work;
        given[i] += turned_over[k] ? fabs(work) : 0.0;
    }
}

/* add a step that was taken */
static void keep_ledger(const march *m, block *b) {
    const double sixth = 1.0 / 6.0;
    column middle[ENTRIES + 1], last[ENTRIES + 1], time, end, swung[3], given;
    if (BALANCED) {
        add_flows(b, b->state, b->one, 0.25, sixth);
        add_flows(b, b->half, b->one, 0.25, 2.0 * sixth);
        add_flows(b, b->half, b->two, 0.25, 2.0 * sixth);
        add_flows(b, b->full, b->two, 0.25, sixth);
    }
    if (!ENTRIES) return;
    EACH(i) {
        time[i] = b->time[i] + 0.5 * b->length[i];
        end[i] = b->time[i] + b->length[i];
        swung[0][i] = swung[1][i] = swung[2][i] = given[i] = 0.0;
    }
    enter_at(m, b, b->half, time, 0, middle);
    enter_at(m, b, b->full, end, 1, last);
    for (long k = 0; k < HELD; k++)
        EACH(i) {
            const double change = last[k][i] - b->entries[k][i];
            b->accounts[account_of[k]][i] += change;
            swung[store_of[k]][i] += 0.5 * fabs(change);
        }
    for (long k = 0; k < EFFORTS; k++) add_work(b, k, middle, last, given);
    EACH(i) {
        const long k = ENTRIES - 1;
        b->accounts[ACCOUNTS - 2][i] += swung[1][i];
        b->accounts[ACCOUNTS - 1][i] += larger(given[i], swung[2][i]);
        if (BALANCED) b->lost[i] += sixth * b->length[i] * (b->entries[k][i] + 4.0 * middle[k][i] + last[k][i]);
    }
    memcpy(b->entries, last, sizeof(column) * ENTRIES);
}
