/* Decisions about forgotten branches of laws: martensite/simulate/forks.py, over lanes. Before this text stands
   samples.c, and of each fork the fraction that it is part of (FORK_PARTS) and FORK_WEIGHTS. */

#if FORKS
enum { BRANCH, BEFORE_OWN, BEFORE_OTHER, REST, BOUND, FORK };
/* of the last point; of the decision of the branch in progress (margin HUGE_VAL without one); and of the decision of
   the branch that the surface ended (branch 0 without one) */
enum { LAST, FAR, LEFT, ALLOWS, WHEN, OLDER, NEAR, TIME, KEPT, FROM, RATIO, DEPTH, SINCE, ENDED, HAD, OPEN, ENTRY, WATCHED };

static const long fork_parts[FORKS + 1] = FORK_PARTS;
static const double fork_weights[FORKS + 1] = FORK_WEIGHTS;

static void begin_forks(block *b, const flags_of_lanes begins) {
    for (long k = 0; k < FORKS * WATCHED; k++) {
        column *w = b->watched[k / WATCHED] + k % WATCHED;
        const double first = k % WATCHED == NEAR ? HUGE_VAL : k % WATCHED == OLDER ? -HUGE_VAL : 0.0;
        EACH(i) (*w)[i] = begins[i] ? first : (*w)[i];
    }
}

/* close, open and follow decisions of one fork */
static void follow_fork(block *b, long k, const column *n, const flags_of_lanes taken, double share) {
    column *w = b->watched[k], *d = b->decided;
    EACH(i) {
        const double least = share * b->scale[fork_parts[k]][i];
        const double branch = n[BRANCH][i], last = w[LAST][i], far = w[FAR][i], rest = w[LEFT][i];
        const double allows = w[ALLOWS][i], when = w[WHEN][i], ended = w[ENDED][i], had = w[HAD][i];
        const long long t = taken[i], same = branch == last;
        const double lost = allows > 0.0 ? rest - rest * rest / allows : 0.0;
        const long long returns = !same & (ended != 0.0) & (ended == branch);
        const long long dips = same & (lost > least) & (w[OLDER][i] >= far) & (far > -ROUNDED) &
                               (n[BEFORE_OTHER][i] > far) & (far < fabs(w[NEAR][i]));
        const long long ends = !same & (last != 0.0) & (branch != 0.0) & (lost > least);
        const double waits = same ? w[NEAR][i] : HUGE_VAL;
        const double near = returns ? w[DEPTH][i] : dips ? far : waits;
        const double since = returns ? w[SINCE][i] : dips ? when : w[TIME][i];
        const double kept = returns ? had : dips ? rest : w[KEPT][i];
        const double from = returns ? w[OPEN][i] : dips ? allows : w[FROM][i];
        const double ratio = returns ? w[OPEN][i] / (had > 0.0 ? had : 1.0) : dips ? 1.0 : w[RATIO][i];
        const double begun = same ? ended : ends ? last : 0.0;
        const double entry = same ? w[ENTRY][i] : smaller(far, 0.0), deep = same ? w[DEPTH][i] : 0.0;
        const double behind = begun != 0.0 ? smaller(deep, n[BEFORE_OWN][i] - entry) : deep;
        const double bound = ratio * n[BOUND][i], open = near < HUGE_VAL ? 1.0 : 0.0;
        const double found = open * (smaller(kept, bound) - kept * bound / (from > 0.0 ? from : 1.0));
        const long long closer = t & (found > least) & (fabs(near) <= fabs(d[0][i]));
        const long long again = (since == d[1][i]) & (d[3][i] == (double)k);
        d[2][i] = closer ? (again ? larger(found, d[2][i]) : found) : d[2][i];
        d[0][i] = closer ? near : d[0][i];
        d[1][i] = closer ? since : d[1][i];
        d[3][i] = closer ? (double)k : d[3][i];
        d[4][i] = closer ? branch : d[4][i];
        w[SINCE][i] = t & !same ? when : w[SINCE][i];
        w[HAD][i] = t & !same ? rest : had;
        w[OPEN][i] = t & !same ? allows : w[OPEN][i];
        w[ENDED][i] = t ? begun : ended;
        w[ENTRY][i] = t ? entry : w[ENTRY][i];
        w[DEPTH][i] = t ? behind : w[DEPTH][i];
        w[NEAR][i] = t ? near : w[NEAR][i];
        w[TIME][i] = t ? since : w[TIME][i];
        w[KEPT][i] = t ? kept : w[KEPT][i];
        w[FROM][i] = t ? from : w[FROM][i];
        w[RATIO][i] = t ? ratio : w[RATIO][i];
    }
}

/* whether a fork has a decision in some lane, or may have one now */
static int may_decide(const block *b, long k, const column *n, const flags_of_lanes taken) {
    const column *w = b->watched[k];
    flags_of_lanes may;
    EACH(i) {
        const long long dips = (w[OLDER][i] >= w[FAR][i]) & (n[BEFORE_OTHER][i] > w[FAR][i]);
        const long long open = (w[NEAR][i] < HUGE_VAL) | (w[ENDED][i] != 0.0);
        may[i] = taken[i] & (dips | open | (n[BRANCH][i] != w[LAST][i]));
    }
    return any(may);
}

/* the point of a fork is the last one now */
static void shift_fork(column *w, const column *n, const column time, const flags_of_lanes taken) {
    EACH(i) {
        const long long t = taken[i], same = (n[BRANCH][i] == w[LAST][i]) & (n[BRANCH][i] != 0.0);
        w[OLDER][i] = t ? (same ? w[FAR][i] : -HUGE_VAL) : w[OLDER][i];
        w[LAST][i] = t ? n[BRANCH][i] : w[LAST][i];
        w[FAR][i] = t ? n[BEFORE_OTHER][i] : w[FAR][i];
        w[LEFT][i] = t ? n[REST][i] : w[LEFT][i];
        w[ALLOWS][i] = t ? n[BOUND][i] : w[ALLOWS][i];
        w[WHEN][i] = t ? time[i] : w[WHEN][i];
    }
}

static void see_forks(const march *m, block *b, column *states, const column time, const flags_of_lanes taken) {
    column now[FORKS * FORK];
    k_forks(LANES, *b->c, *states, *now);
    for (long k = 0; k < FORKS; k++) {
        const column *n = now + k * FORK;
        if (may_decide(b, k, n, taken)) follow_fork(b, k, n, taken, COUNTS * m->tolerance / fork_weights[k]);
        shift_fork(b->watched[k], n, time, taken);
    }
}

/* the points in the middle and at the end of accepted steps */
static void watch_forks(const march *m, block *b, const flags_of_lanes taken, const column end) {
    column middle;
    if (!m->parted) return;
    EACH(i) middle[i] = b->time[i] + 0.5 * b->length[i];
    see_forks(m, b, b->half, middle, taken);
    see_forks(m, b, b->full, end, taken);
}
#endif
