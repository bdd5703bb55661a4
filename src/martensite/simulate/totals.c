/* Lowest and highest value of every output of runs, and its integral over time, from every accepted step: what
   martensite/simulate/track.py computes from a record, for many runs without one.

   Before this text stands drives.c with what it asks for. A drive that is not constant in a half step is
   replaced by four levels with its mean, its mean square and its extremes. If it jumps or swings there (its lapse is
   above 0), these extremes are those of the outputs, too. Between the nodes of other steps outputs follow a parabola,
   if its second derivative is near that half a step before: there is no kink. */

#define BROUGHT(part, k, which, i) ((part) ? b->two[k][which][i] : b->one[k][which][i])

static void find_levels(double mean, double square, double low, double high, double *level, double *share) {
    const double centre = 0.5 * (low + high), reach = high > low ? 0.5 * (high - low) : 1.0;
    double first = (mean - centre) / reach;
    first = first > 1.0 ? 1.0 : first < -1.0 ? -1.0 : first;
    double second = (square - 2.0 * centre * mean + centre * centre) / (reach * reach);
    second = second > 1.0 ? 1.0 : second < first * first ? first * first : second;
    const int outer = second >= fabs(first);
    const double spread = square > mean * mean ? sqrt(square - mean * mean) : 0.0;
    const double down = mean - spread > low ? mean - spread : low, up = mean + spread < high ? mean + spread : high;
    level[0] = low;
    level[1] = outer ? centre : down;
    level[2] = outer ? centre : up;
    level[3] = high;
    share[0] = outer ? 0.5 * (second - first) : 0.0;
    share[3] = outer ? 0.5 * (second + first) : 0.0;
    share[1] = share[2] = 0.5 * (1.0 - share[0] - share[3]);
}

static void observe_at(block *b, const column *states, const column *signals, column *row) {
    memcpy(b->x2, states, sizeof(column) * SIZE);
    if (OBSERVE_SIGNALS) memcpy(b->x2 + SIZE, signals, sizeof(column) * DRIVES);
    k_observe(LANES, *b->c, *b->x2, *row);
}

/* outputs with their weights in integrals [s], of runs whose extremes they count for */
static void count_row(block *b, const column *row, const column weight, const long long *counts) {
    for (long k = 0; k < OUTPUTS; k++)
        EACH(i) {
            b->sum[k][i] += weight[i] != 0.0 ? weight[i] * row[k][i] : 0.0;
            b->lowest[k][i] = counts[i] & (row[k][i] < b->lowest[k][i]) ? row[k][i] : b->lowest[k][i];
            b->highest[k][i] = counts[i] & (row[k][i] > b->highest[k][i]) ? row[k][i] : b->highest[k][i];
        }
}

/* peaks between the nodes of steps in which no drive jumps or swings, and before which none does */
static void count_peaks(block *b, const column (*rows)[OUTPUTS + 1], const long long *counts) {
    for (long k = 0; k < OUTPUTS; k++)
        EACH(i) {
            const double first = rows[0][k][i], middle = rows[1][k][i], last = rows[2][k][i];
            const double bend = first - 2.0 * middle + last, rise = last - first, size = fabs(bend);
            const double per = 0.5 * b->length[i] / b->last_half[i];
            const double earlier = 2.0 * (middle - first - (first - b->last_middle[k][i]) * per) / (1.0 + per) * per;
            const long long turns = counts[i] & !b->at_edge[i] & (fabs(rise) < 2.0 * size);
            const long long smooth = turns & (fabs(earlier - bend) <= 0.1 * size);
            const double top = middle - rise * rise / (8.0 * (smooth ? bend : 1.0));
            b->lowest[k][i] = smooth ? smaller(top, b->lowest[k][i]) : b->lowest[k][i];
            b->highest[k][i] = smooth ? larger(top, b->highest[k][i]) : b->highest[k][i];
        }
}

#if OBSERVE_SIGNALS
/* half steps in which drives are not constant, each drive at its levels while the others are at their means */
static void count_levels(march *m, block *b, const long long *varied, const column (*signals)[DRIVES + 1]) {
    column row[OUTPUTS + 1], level[4], share[4], weight, means[DRIVES + 1];
    long long counts[LANES];
    long heating = 0;
    for (long k = 0; k < DRIVES; k++) heating += widths[k] > 1;
    for (long part = 0; part < 2; part++) {
        const column *ends[2] = {part ? b->half : b->state, part ? b->full : b->half};
        for (long k = 0; k < DRIVES; k++)
            for (long i = 0; i < LANES; i++)
                means[k][i] = widths[k] > 1 ? BROUGHT(part, k, MEAN, i) : signals[1][k][i];
        for (long side = 0; side < 2; side++) {
            const double own = (side == part ? 1.0 : 2.0) * (1.0 / 6.0);
            if (heating > 1) {
                for (long i = 0; i < LANES; i++) {
                    weight[i] = varied[i] ? (double)(1 - heating) * own * b->length[i] : 0.0;
                    counts[i] = 0;
                }
                observe_at(b, ends[side], means, row);
                count_row(b, row, weight, counts);
            }
            for (long k = 0; k < DRIVES; k++) {
                if (widths[k] == 1) continue;
                for (long i = 0; i < LANES; i++) {
                    double levels[4], shares[4];
                    find_levels(BROUGHT(part, k, MEAN, i), BROUGHT(part, k, SQUARE, i), BROUGHT(part, k, LOW, i),
                                BROUGHT(part, k, HIGH, i), levels, shares);
                    for (long l = 0; l < 4; l++) {
                        level[l][i] = levels[l];
                        share[l][i] = shares[l];
                    }
                }
                for (long l = 0; l < 4; l++) {
                    column kept;
                    memcpy(kept, means[k], sizeof kept);
                    for (long i = 0; i < LANES; i++) {
                        means[k][i] = level[l][i];
                        weight[i] = varied[i] ? own * share[l][i] * b->length[i] : 0.0;
                        counts[i] = varied[i] && (l == 0 || l == 3) && BROUGHT(part, k, LAPSE, i) > 0.0;
                    }
                    observe_at(b, ends[side], means, row);
                    count_row(b, row, weight, counts);
                    memcpy(means[k], kept, sizeof kept);
                }
            }
        }
    }
    (void)m;
}
#endif

/* the start of runs, at the outputs in a row */
static void begin_totals(block *b, const column *row, const long long *begins) {
    for (long k = 0; k < OUTPUTS; k++)
        for (long i = 0; i < LANES; i++)
            if (begins[i]) {
                b->lowest[k][i] = b->highest[k][i] = b->last_row[k][i] = row[k][i];
                b->sum[k][i] = 0.0;
            }
}

/* what steps that are taken add */
static void add_totals(march *m, block *b, const long long *taken) {
    column rows[3][OUTPUTS + 1], signals[3][DRIVES + 1], weight;
    const column *states[3] = {b->state, b->half, b->full};
    long long varied[LANES], smooth[LANES], any_varied = 0;
    for (long i = 0; i < LANES; i++) {
        varied[i] = 0;
        smooth[i] = taken[i];
    }
    for (long k = 0; k < DRIVES; k++)
        for (long i = 0; i < LANES; i++) {
            const double begin = b->time[i], length = b->length[i];
            for (long j = 0; j < 3 && OBSERVE_SIGNALS; j++)
                signals[j][k][i] = value_of(m, b, k, i, begin + 0.5 * (double)j * length, j == 2);
            for (long part = 0; part < 2 && widths[k] > 1; part++) {
                if (BROUGHT(part, k, LAPSE, i) > 0.0) smooth[i] = 0;
                if (OBSERVE_SIGNALS && BROUGHT(part, k, HIGH, i) > BROUGHT(part, k, LOW, i)) varied[i] = taken[i];
            }
        }
    memcpy(rows[0], b->last_row, sizeof(column) * OUTPUTS);
    for (long j = OBSERVE_SIGNALS ? 0 : 1; j < 3; j++) observe_at(b, states[j], signals[j], rows[j]);
    for (long j = 0; j < 3; j++) {
        EACH(i)
            weight[i] = taken[i] & !varied[i] ? (j == 1 ? 4.0 : 1.0) * (1.0 / 6.0) * b->length[i] : 0.0;
        count_row(b, rows[j], weight, taken);
    }
    count_peaks(b, rows, smooth);
    for (long i = 0; i < LANES; i++) any_varied |= varied[i];
#if OBSERVE_SIGNALS
    if (any_varied) count_levels(m, b, varied, signals);
#endif
    for (long k = 0; k < OUTPUTS; k++) {
        BLEND(b->last_middle[k], taken, rows[1][k]);
        BLEND(b->last_row[k], taken, rows[2][k]);
    }
}

static void tell_totals(const march *m, const block *b, long run, long i) {
    if (!m->totals) return;
    double *own = m->totals + run * 3 * OUTPUTS;
    for (long k = 0; k < OUTPUTS; k++) {
        own[k] = b->lowest[k][i];
        own[OUTPUTS + k] = b->highest[k][i];
        own[2 * OUTPUTS + k] = b->sum[k][i];
    }
}
