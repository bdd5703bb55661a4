/* The ledgers of a march, as in martensite/simulate/ledger.py.

   Before this text stand martensite/simulate/marching.c with what it asks for, the kernels k_entries
   and k_flows, and: HELD energies and EFFORTS of k_entries, BALANCED if it ends with a loss;
   FLOWS numbers of k_flows, what comes in and, if a signal lets it out, what is lost;
   ACCOUNT_OF all of them, STORE_OF each energy what it is to what is exchanged, TURNED_OVER of each effort
   whether it is, ENTRY_SIGNALS whether k_entries asks for signals. */

static const long account_of[HELD + EFFORTS + 1] = ACCOUNT_OF;
static const long store_of[HELD + 1] = STORE_OF;
static const long turned_over[EFFORTS + 1] = TURNED_OVER;

static void enter_at(const march *m, block *b, const column *states, double time, int before,
                     column *entries) {
    memcpy(b->x2, states, sizeof(column) * SIZE);
    if (ENTRY_SIGNALS) put_signals(m, b, time, before, b->x2 + SIZE);
    k_entries(LANES, *b->c, *b->x2, *entries);
}

static void begin_ledger(const march *m, block *b) {
    if (ENTRIES) enter_at(m, b, b->state, b->time, 0, b->entries);
}

/* a part of what came in in a step, and of what a signal let out, from what drives bring at a state */
static void add_flows(block *b, const column *states, const moments (*found)[DRIVES + 1],
                      double part, double let_out) {
    column flow[2];
    memcpy(b->x2, states, sizeof(column) * SIZE);
    feed(found, 0, 0.0, b->x2 + SIZE);
    k_flows(LANES, *b->c, *b->x2, *flow);
    EACH(i) b->put_in[i] += part * flow[0][i];
    if (FLOWS > 1) EACH(i) b->lost[i] += let_out * flow[1][i];
}

/* the work of an effort in the step, all three numbers of both on parabolas */
static void add_work(block *b, long k, column given) {
    const long at = HELD + 2 * k, account = account_of[HELD + k];
    const column *f = b->entries + at, *g = b->middle_entries + at, *h = b->last_entries + at;
    EACH(i) {
        const double half = 4.0 * (g[1][i] - f[1][i]), whole = h[1][i] - f[1][i];
        const double sum = f[0][i] * (half - whole) + 4.0 * g[0][i] * whole +
                           h[0][i] * (3.0 * whole - half);
        const double work = sum * (1.0 / 6.0);
        b->accounts[account][i] += work;
        if (turned_over[k]) given[i] += fabs(work);
    }
}

static void keep_ledger(const march *m, block *b) {
    if (BALANCED) {
        const double part = 0.25 * b->length;
        const double end = b->length * (1.0 / 6.0);
        add_flows(b, b->state, b->one, part, end);
        add_flows(b, b->half, b->one, part, 2.0 * end);
        add_flows(b, b->half, b->two, part, 2.0 * end);
        add_flows(b, b->full, b->two, part, end);
    }
    if (!ENTRIES) return;
    enter_at(m, b, b->half, b->time + 0.5 * b->length, 0, b->middle_entries);
    enter_at(m, b, b->full, b->time + b->length, 1, b->last_entries);
    column swung[3], given;
    memset(swung, 0, sizeof swung);
    memset(given, 0, sizeof given);
    for (long k = 0; k < HELD; k++)
        EACH(i) {
            const double change = b->last_entries[k][i] - b->entries[k][i];
            b->accounts[account_of[k]][i] += change;
            swung[store_of[k]][i] += 0.5 * fabs(change);
        }
    for (long k = 0; k < EFFORTS; k++) add_work(b, k, given);
    EACH(i) {
        b->accounts[ACCOUNTS - 2][i] += swung[1][i];
        b->accounts[ACCOUNTS - 1][i] += given[i] > swung[2][i] ? given[i] : swung[2][i];
    }
    if (BALANCED) {
        const double sixth = b->length * (1.0 / 6.0);
        const long k = ENTRIES - 1;
        EACH(i) b->lost[i] += sixth * (b->entries[k][i] + 4.0 * b->middle_entries[k][i] +
                                       b->last_entries[k][i]);
    }
    memcpy(b->entries, b->last_entries, sizeof(column) * ENTRIES);
}
