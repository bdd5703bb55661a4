/* Lengths of steps: up to edges of drives and kinks of laws. Before this text stands runs.c, and of each point of a law
   its START among the numbers of all and its SIZES. SAFETY and other numbers are those of adaptive.py. */

static const long start_of[POINTS + 1] = START;
static const long size_of_point[POINTS + 1] = SIZES;

/* length to the first edge of a drive within a length; how many edges there are, up to FEW + 1 */
static double find_edge(const march *m, const block *b, long k, long i, double length, long *count) {
    const double begin = b->time[i];
    const drive *d = drive_of(m, b->now + k, k, i);
    return first_edge(d, begin + SHORTEST * m->duration, begin + length, b->now[k].cursor[i], count) - begin;
}

INLINE double reach_end(double length, double end) {
    return length >= (1.0 - STEP_TOLERANCE) * end ? end : length > 0.6 * end ? 0.5 * end : length;
}

/* a length that no signal which prescribes a state makes too long */
static double before_prescribed(const march *m, const block *b, long i, double length, double end) {
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] > 1) continue;
        long count;
        const double fastest = drive_of(m, b->now + k, k, i)->fastest;
        if (fastest > 0.0 && PRESCRIBED / fastest < length) length = PRESCRIBED / fastest;
        const double edge = find_edge(m, b, k, i, (1.0 + STEP_TOLERANCE) * length, &count);
        if (count && edge < end) end = edge;
    }
    return reach_end(length, end);
}

/* a shorter length: to the first edge of a drive that heats, or what resolves its tones */
static double to_edge(const march *m, const block *b, long i) {
    double length = b->length[i];
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] == 1) continue;
        long count;
        const double fastest = drive_of(m, b->now + k, k, i)->fastest;
        const double edge = find_edge(m, b, k, i, (1.0 - STEP_TOLERANCE) * length, &count);
        if (count) length = edge;
        if (fastest > 0.0 && SWING / fastest < length) length = SWING / fastest;
    }
    return length;
}

/* a length that ends on the first of few edges; of a run in parts the last one before an edge is
   split */
static double before_few_edges(const march *m, block *b, long i) {
    double length = b->length[i];
    long whole = 0;
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] == 1) continue;
        long count;
        const double edge = find_edge(m, b, k, i, (1.0 + STEP_TOLERANCE) * length, &count);
        if (count && count <= FEW) length = reach_end(length, edge);
        whole |= count && count <= FEW && length >= edge;
    }
    if (!m->parted || !whole || b->split[i]) return length;
    b->split[i] = 1;
    return 0.5 * length;
}

/* whether a signal that prescribes a state jumps at the start of a step */
static int is_jump(const march *m, const block *b, long i) {
    int jumps = 0;
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] > 1) continue;
        jumps |= value_of(m, b, k, i, b->time[i], 0) != value_of(m, b, k, i, b->time[i], 1);
    }
    return jumps;
}

/* the length of the next step of lanes that begin one */
static void plan_lengths(const march *m, block *b) {
    column allowed, length;
    int prescribed = 0;
    for (long k = 0; k < DRIVES; k++) prescribed |= widths[k] == 1;
    EACH(i) {
        const double end = m->duration - b->time[i];
        allowed[i] = reach_end(smaller(limit_length(m, b, i), end), end);
    }
    if (prescribed)
        EVERY(i) if (b->fresh[i]) {
            const double end = m->duration - b->time[i];
            allowed[i] = before_prescribed(m, b, i, smaller(b->next[i], end), end);
        }
    memcpy(length, allowed, sizeof(column));
    /* to the next kink of a law, if all goes on as in the last half step */
    for (long place = 0; place < POINTS; place++)
        for (long k = start_of[place] + 4; k < start_of[place] + size_of_point[place]; k++)
            EACH(i) {
                const double now = b->points[k][i], fallen = b->earlier_points[k][i] - now;
                const long long ahead = (now > LEAST_FALL) & (fallen > 0.0);
                const double there = SHORT * now / (ahead ? fallen : 1.0) * b->last_half[i];
                const long long late = (KINK_MARGIN * allowed[i] < there) & (m->shortest < there);
                const long long kink = ahead & late & (there < length[i]) & !(ORDER == 5 && b->on_surface[i]);
                length[i] = kink ? there : length[i];
#if ORDER == 5 /* across a kink that is nearly reached; others are found in the step */
                const double gap = now / (ahead ? fallen : 1.0) * b->last_half[i];
                const long long near = ahead & (gap <= KINK_MARGIN * allowed[i]) & b->on_surface[i];
                const double least = larger(2.0 * LEAST_SMOOTH * m->duration, m->shortest);
                length[i] = near ? smaller(length[i], larger(ACROSS * gap, least)) : length[i];
#endif
            }
    if (FOLLOWS)
        EVERY(i) if (b->fresh[i]) {
            b->leaps[i] = is_jump(m, b, i);
            length[i] = b->leaps[i] ? LEAP * allowed[i] : length[i];
        }
    EACH(i) {
        const double planned = length[i] < allowed[i] ? allowed[i] : 0.0;
        b->length[i] = b->fresh[i] ? length[i] : b->length[i];
        b->planned[i] = b->fresh[i] ? planned : b->planned[i];
        b->grows[i] = b->fresh[i] ? (ORDER == 5 ? MOST_GROWTH : MOST_CHANGE) : b->grows[i];
    }
}

/* lengths over which the mean of no drive leaves out too much, and what the halves bring */
static void resolve_lengths(const march *m, block *b) {
    flags_of_lanes asked;
    EACH(i) asked[i] = 1;
    for (long k = 0; k < DRIVES; k++) {
        if (widths[k] == 1) continue;
        flags_of_lanes inside;
        EACH(i) inside[i] = b->now[k].following[i] <= b->time[i] + (1.0 + STEP_TOLERANCE) * b->length[i];
        if (!any(inside)) continue;
        EVERY(i) if (b->live[i]) b->length[i] = before_few_edges(m, b, i);
        break;
    }
    do {
        bring_all(m, b, asked);
        EACH(i) {
            const double heat = JUDGED ? b->scale[0][i] : 1.0;
            asked[i] = b->live[i] & (b->lapse[i] > 0.0) & !(b->power[i] * b->lapse[i] <= m->tolerance * heat);
        }
        SOME(i, bits_of(asked)) {
            const double shorter = to_edge(m, b, i);
            asked[i] = shorter < b->length[i];
            if (asked[i]) b->length[i] = shorter;
        }
    } while (any(asked));
}
