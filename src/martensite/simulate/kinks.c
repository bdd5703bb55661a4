/* Kinks of laws within steps. Before this text stands lengths.c, and of each point of a law the fraction that it is
   part of (PARTS) and WEIGHTS. */

static const long parts[POINTS + 1] = PARTS;
static const double weights[POINTS + 1] = WEIGHTS;

/* share of a step at which a number falls to 0; else 1 */
static double find_fall(double ahead, double first, double middle, double last) {
    if (!(first > LEAST_FALL && (middle <= 0.0 || last <= 0.0))) return 1.0;
    const int late = middle > 0.0;
    const double begin = late ? 0.5 : 0.0, top = late ? middle : first;
    const double bottom = late ? last : middle;
    if (late) ahead = first - middle;
    return begin + 0.5 * (ahead > top ? top / ahead : top / (top - bottom));
}

/* share of a step at which what drives the law at a point turns, if that counts; else 1 */
INLINE double find_turn(const block *b, long at, long i, double changed, double most) {
    const column *p = b->earlier_points + at, *q = b->points + at;
    const column *a = b->points_half + at, *z = b->points_full + at;
    const double e = p[0][i] - p[1][i] * PER_STRESS, f = q[0][i] - q[1][i] * PER_STRESS;
    const double g = a[0][i] - a[1][i] * PER_STRESS, h = z[0][i] - z[1][i] * PER_STRESS;
    const double bend = (h - g) - (g - f), rise = h - f;
    const int turns = fabs(rise) < 2.0 * fabs(bend);
    const double per = 1.0 / (turns ? bend : 1.0), top = g - 0.125 * rise * rise * per;
    const double share = 0.5 - 0.25 * rise * per;
    const double moved = fabs(f - e) + fabs(g - f) + fabs(h - g);
    const double apart = smaller(smaller(fabs(top - f), fabs(top - g)), fabs(top - h));
    const int counts = turns & (changed > most) & (BESIDE < share) & (share < 1.0 - BESIDE) &
                       (changed * apart > most * moved);
    return counts ? share : 1.0;
}

/* whether a step misses much of a bend near one of its ends, which its error does not show */
static int hides_bend(const block *b, long at, long i, double share, double allowed) {
    const double ratio = 0.5 * b->length[i] / b->last_half[i];
    const int late = share > 0.5;
    double most = 0.0;
    if (!(0.0 < share && share < EDGE) && !(1.0 - EDGE < share && share < 1.0 - BESIDE)) return 0;
    for (long k = at + 2; k < at + 4; k++) {
        const double e = b->earlier_points[k][i], f = b->points[k][i];
        const double g = b->points_half[k][i], h = b->points_full[k][i];
        const double missed = late ? fabs((h - g) - (g - f)) : 2.0 * share * fabs((g - f) - ratio * (f - e));
        most = missed > most ? missed : most;
    }
    return most > allowed;
}

/* share of a step at which the law at a point bends, if that counts; else 1 */
static double find_bend(const block *b, long place, long i, double most) {
    const long at = start_of[place];
    const column *p = b->earlier_points + at, *q = b->points + at;
    const column *a = b->points_half + at, *z = b->points_full + at;
    const double ratio = 0.5 * b->length[i] / b->last_half[i];
    double first = 1.0;
    for (long k = 4; k < size_of_point[place]; k++) {
        const double ahead = ratio * (p[k][i] - q[k][i]);
        const double share = find_fall(ahead, q[k][i], a[k][i], z[k][i]);
        const int seen = b->error[i] > 1.0 && BESIDE < share && share < 1.0 - BESIDE;
        if (share < first && (seen || hides_bend(b, at, i, share, HIDDEN / TURN * most))) first = share;
    }
    return first;
}

/* share of each step at which its law turns or bends; 1 if that does not count */
static void find_kinks(const march *m, block *b) {
    EACH(i) b->kink[i] = 1.0;
#if ORDER == 5
    cut_at_events(b);
#endif
    for (long place = 0; place < POINTS; place++) {
        const long at = start_of[place];
        /* numbers that turn, and may pass 0 there and nowhere else */
        for (long k = at + 4; k < at + size_of_point[place]; k++)
            EACH(i) {
                const double f = b->points[k][i], g = b->points_half[k][i], h = b->points_full[k][i];
                const double bend = (h - g) - (g - f), rise = h - f, least = smaller(smaller(f, h), g);
                const int turns = (least > LEAST_FALL) & (fabs(rise) < 2.0 * bend);
                const double per = 1.0 / (turns ? bend : 1.0), low = g - 0.125 * rise * rise * per;
                const double share = 0.5 - 0.25 * rise * per;
                const int dips = turns & (low + low < least) & (BESIDE < share) & (share < 1.0 - BESIDE) &
                                 (share < b->kink[i]) & !(ORDER == 5 && b->on_surface[i]);
                b->kink[i] = dips ? share : b->kink[i];
            }
        const double share = TURN * m->tolerance / weights[place];
        column changed, most;
        flags_of_lanes counts, bends;
        EACH(i) changed[i] = 0.0;
        for (long k = at + 2; k < at + 4; k++)
            EACH(i) {
                const double sum = fabs(b->points[k][i] - b->earlier_points[k][i]) +
                                   fabs(b->points_half[k][i] - b->points[k][i]) +
                                   fabs(b->points_full[k][i] - b->points_half[k][i]);
                changed[i] = larger(changed[i], sum);
            }
        EACH(i) most[i] = share * b->scale[parts[place]][i];
        EACH(i) {
            counts[i] = changed[i] > most[i];
            bends[i] = 0;
        }
#if ORDER == 5
        cut_at_reversals(b, most);
        cut_at_touches(b, most);
        EACH(i) counts[i] &= !b->on_surface[i];
#endif
        if (!any(counts)) continue;
        EACH(i) b->kink[i] = smaller(find_turn(b, at, i, changed[i], most[i]), b->kink[i]);
        for (long k = at + 4; k < at + size_of_point[place]; k++)
            EACH(i) bends[i] |= (b->points[k][i] > LEAST_FALL) &
                                ((b->points_half[k][i] <= 0.0) | (b->points_full[k][i] <= 0.0));
        EACH(i) bends[i] &= counts[i];
        SOME(i, bits_of(bends)) b->kink[i] = smaller(find_bend(b, place, i, most[i]), b->kink[i]);
    }
}
