/* Elements as actuators of MuJoCo: the bias of an actuator of type `user` is the force of an element.

   Over a step dt the length of the path of element i is taken for

       l_i(F) = l_i + dt J_i (v + dt M'^-1 (f - sum_j J_j^T F_j)),    M' = M + dt D

   with all that MuJoCo knows when it asks for the force: f are its smooth forces, the forces of other actuators, and
   those of contacts and limits one step ago; D is the joint damping that its integrator takes at the end of the step.
   The force on the model during a step is a weighted mean of the forces at its end, at its start, and one step
   earlier. That is a load line for every element, and the kernel of the element solves law, heat and force on it at once.

   Everything that changes stands in `userdata` of mjData, so that copies, resets and saved states hold it:
   [0] begun, [1] time of the step; then for every element its force at the end, drive, reach and give of
   the step, the fraction of a strip that it crossed, its force at the start of the step and of the step before, its
   state at the start, and its state at the end. A step counts when time has gone on; asked again at the same time, it is made
   anew. Below this stand the kernels, and above it STRANDS, KEPT (the largest state) and kernel types. */

enum { HEAD = 2, OWN = 7 };
enum { FINE = 0, UNSOLVED = 1, UNBALANCED = 2, TURNED_BACK = 3, WRONG_INTEGRATOR = 4, NO_ROOM = 5 };

typedef void (*Kernel)(const double *, const double *, const double *, double, double *);
typedef void (*Prepare)(const double *, double *);

typedef struct {
    Kernel step;
    int states, place; /* numbers of its state, and place of what it keeps in userdata */
    double reference, force;
    double start[KEPT], constants[CONSTANTS];
} Strand;

typedef struct {
    Strand strands[STRANDS];
    double weight_end, weight_start, weight_before; /* of the forces that act in a step; their sum is 1 */
    int failure, fallen; /* the first failure, and its element */
    double failed_at;
} Group;

/* Room for numbers, of this thread, until the next call. */
static double *find_room(size_t count) {
    static __thread double *room;
    static __thread size_t size;
    if (count > size) {
        free(room);
        room = malloc(sizeof(double) * count);
        size = room ? count : 0;
    }
    return room;
}

static int damps_at_end(const mjModel *m) {
    return m->opt.integrator != mjINT_EULER || !(m->opt.disableflags & mjDSBL_EULERDAMP);
}

typedef struct {
    const mjModel *m;
    const double *L, *inverse; /* of M' = L^T D L, and of D */
} Mass;

/* M' = L^T D L in the rows of M; after R. Featherstone (2008), section 6.5. Without damping MuJoCo has it already. */
static Mass factor_mass(const mjModel *m, const mjData *d, double *L, double *inverse) {
    Mass found = {m, d->qLD, d->qLDiagInv};
    int k, e, j;
    for (k = 0; k < m->nv && m->dof_damping[k] == 0.0; k++);
    if (k == m->nv || !damps_at_end(m)) return found;
    memcpy(L, d->M, sizeof(double) * (size_t)m->nC);
    for (k = m->nv - 1; k >= 0; k--) {
        double *restrict row = L + m->M_rowadr[k];
        const int *columns = m->M_colind + m->M_rowadr[k], diagonal = m->M_rownnz[k] - 1;
        row[diagonal] += m->opt.timestep * m->dof_damping[k];
        inverse[k] = 1.0 / row[diagonal];
        for (e = diagonal - 1; e >= 0; e--) {
            double *restrict other = L + m->M_rowadr[columns[e]], share = row[e] * inverse[k];
            for (j = 0; j <= e; j++) other[j] = fma(-share, row[j], other[j]);
        }
        for (e = 0; e < diagonal; e++) row[e] *= inverse[k];
    }
    found.L = L, found.inverse = inverse;
    return found;
}

static void solve_mass(const Mass *a, double *x) {
    const mjModel *m = a->m;
    int k, e;
    for (k = m->nv - 1; k >= 0; k--) {
        const double *row = a->L + m->M_rowadr[k];
        const int *columns = m->M_colind + m->M_rowadr[k];
        if (x[k] != 0.0)
            for (e = m->M_rownnz[k] - 2; e >= 0; e--) x[columns[e]] -= row[e] * x[k];
    }
    for (k = 0; k < m->nv; k++) {
        const double *row = a->L + m->M_rowadr[k];
        const int *columns = m->M_colind + m->M_rowadr[k];
        x[k] *= a->inverse[k];
        for (e = m->M_rownnz[k] - 2; e >= 0; e--) x[k] -= row[e] * x[columns[e]];
    }
}

static double times_row(const mjData *d, int row, const double *x) {
    double sum = 0.0;
    int e;
    for (e = 0; e < d->moment_rownnz[row]; e++)
        sum += d->actuator_moment[d->moment_rowadr[row] + e] * x[d->moment_colind[d->moment_rowadr[row] + e]];
    return sum;
}

static void add_row(const mjData *d, int row, double share, double *x) {
    int e;
    for (e = 0; e < d->moment_rownnz[row]; e++)
        x[d->moment_colind[d->moment_rowadr[row] + e]] += share * d->actuator_moment[d->moment_rowadr[row] + e];
}

/* Where the paths end without the elements, reach[i] above their reference, and what they yield, S[i][j] [m/N]. */
static int lay_lines(const Group *group, const mjModel *m, const mjData *d, int first, const int *rows, double *reach,
                     double S[STRANDS][STRANDS]) {
    double dt = m->opt.timestep, *room, *f, *x[STRANDS];
    int i, j, k, nv = m->nv;
    Mass mass;
    room = find_room((size_t)(m->nC + (2 + STRANDS) * nv));
    if (!room) return 0;
    mass = factor_mass(m, d, room, room + m->nC);
    f = room + m->nC + nv;
    for (k = 0; k < nv; k++) f[k] = d->qfrc_passive[k] - d->qfrc_bias[k] + d->qfrc_applied[k] + d->qfrc_constraint[k];
    for (k = 0; k < first; k++)
        for (j = m->actuator_outadr[k]; j < m->actuator_outadr[k] + m->actuator_outnum[k]; j++) {
            double force = d->actuator_force[j];
            if (m->actuator_forcelimited[k]) /* MuJoCo does so after it has asked for all forces */
                force = fmin(fmax(force, m->actuator_forcerange[2 * k]), m->actuator_forcerange[2 * k + 1]);
            add_row(d, j, force, f);
        }
    for (i = 0; i < STRANDS; i++) {
        x[i] = f + (i + 1) * nv;
        memset(x[i], 0, sizeof(double) * (size_t)nv);
        add_row(d, rows[i], 1.0, x[i]);
        solve_mass(&mass, x[i]);
        reach[i] = d->actuator_length[rows[i]] - group->strands[i].reference + dt * times_row(d, rows[i], d->qvel);
        for (k = 0; k < nv; k++) reach[i] += dt * dt * x[i][k] * f[k];
    }
    for (i = 0; i < STRANDS; i++)
        for (j = 0; j < STRANDS; j++) S[i][j] = dt * dt * times_row(d, rows[i], x[j]);
    return 1;
}

/* One element on its line; its state at the end, (force, free, compliance) last. Whether it is solved. */
static int step_strand(const Strand *one, double *own, double reach, double give, double dt) {
    double y[KEPT + 2], u[3];
    int k;
    own[2] = u[1] = reach, own[3] = u[2] = give, u[0] = own[1];
    one->step(one->constants, own + OWN, u, dt, y);
    for (k = 0; k < one->states + 2; k++)
        if (!(fabs(y[k]) <= DBL_MAX)) return 0;
    memcpy(own + OWN + one->states, y, sizeof(double) * (size_t)one->states);
    own[0] = y[one->states - 3], own[4] = y[one->states + 1];
    return y[one->states] <= SOLVED;
}

/* Forces that balance elements whose paths share joints: tangents (S + C) F = reach - free with F >= 0 give the next
   forces of the others, and every element solves its own line exactly. */
static int balance_strands(Group *group, double *kept, const double *reach, double S[STRANDS][STRANDS], double dt) {
    const Strand *strands = group->strands;
    double F[STRANDS], moved;
    int i, j, turn, sweep;
    for (i = 0; i < STRANDS; i++) F[i] = kept[strands[i].place];
    for (turn = 0; turn < TURNS; turn++) {
        moved = 0.0;
        for (i = 0; i < STRANDS; i++) {
            double *own = kept + strands[i].place, line = reach[i];
            for (j = 0; j < STRANDS; j++)
                if (j != i) line -= S[i][j] * F[j];
            if (!step_strand(strands + i, own, line, S[i][i], dt)) {
                group->fallen = i;
                return UNSOLVED;
            }
            moved = fmax(moved, fabs(own[0] - F[i]) / fmax(own[0], LEAST));
        }
        for (i = 0; i < STRANDS; i++) F[i] = kept[strands[i].place];
        if (STRANDS == 1 || moved <= AGREED) return FINE;
        for (sweep = 0, moved = 1.0; sweep < SWEEPS && moved > AGREED; sweep++)
            for (i = 0, moved = 0.0; i < STRANDS; i++) {
                const double *end = kept + strands[i].place + OWN + 2 * strands[i].states - 2;
                double line = reach[i] - end[0], before = F[i];
                for (j = 0; j < STRANDS; j++)
                    if (j != i) line -= S[i][j] * F[j];
                F[i] = fmax(line / (S[i][i] + end[1]), 0.0);
                moved = fmax(moved, fabs(F[i] - before) / fmax(F[i], LEAST));
            }
    }
    group->fallen = 0;
    return UNBALANCED;
}

static void begin_strands(const Group *group, double *kept) {
    const Strand *strands = group->strands;
    int i;
    for (i = 0; i < STRANDS; i++) {
        double *own = kept + strands[i].place;
        own[0] = own[5] = own[6] = strands[i].force;
        memcpy(own + OWN, strands[i].start, sizeof(double) * (size_t)strands[i].states);
        memcpy(own + OWN + strands[i].states, strands[i].start, sizeof(double) * (size_t)strands[i].states);
    }
    kept[0] = 1.0;
}

/* The part of the force in a step that is known before it is solved. */
static double find_known(const Group *group, const double *own) {
    return group->weight_start * own[5] + group->weight_before * own[6];
}

static int solve_strands(Group *group, const mjModel *m, const mjData *d, int first, double *kept) {
    const Strand *strands = group->strands;
    double reach[STRANDS], S[STRANDS][STRANDS];
    int i, j, rows[STRANDS];
    if (m->opt.integrator == mjINT_RK4 || m->opt.integrator > mjINT_IMPLICITFAST) return WRONG_INTEGRATOR;
    if (kept[0] == 0.0)
        begin_strands(group, kept);
    else if (d->time < kept[1])
        return TURNED_BACK;
    else if (d->time > kept[1])
        for (i = 0; i < STRANDS; i++) {
            double *own = kept + strands[i].place;
            own[6] = own[5], own[5] = own[0];
            memcpy(own + OWN, own + OWN + strands[i].states, sizeof(double) * (size_t)strands[i].states);
        }
    kept[1] = d->time;
    for (i = 0; i < STRANDS; i++) {
        rows[i] = m->actuator_outadr[first + i];
        kept[strands[i].place + 1] = d->ctrl[m->actuator_ctrladr[first + i]];
    }
    if (!lay_lines(group, m, d, first, rows, reach, S)) return NO_ROOM;
    for (i = 0; i < STRANDS; i++)
        for (j = 0; j < STRANDS; j++) {
            reach[i] -= S[i][j] * find_known(group, kept + strands[j].place);
            S[i][j] *= group->weight_end;
        }
    return balance_strands(group, kept, reach, S, m->opt.timestep);
}

/* What MuJoCo asks of every strand, in order: the first finds the forces of all. Tension shortens: it is negative. */
double find_force(Group *group, const mjModel *m, const mjData *d, int id) {
    const double *written = m->actuator_biasprm + id * mjNBIAS;
    double *kept = d->userdata + (int)written[2];
    int i, mine = (int)written[1], found;
    if (mine == 0) {
        found = solve_strands(group, m, d, id, kept);
        if (found != FINE && group->failure == FINE) group->failure = found, group->failed_at = d->time;
        if (found != FINE)
            for (i = 0; i < STRANDS; i++) kept[group->strands[i].place] = NAN;
    }
    kept += group->strands[mine].place;
    return -(group->weight_end * kept[0] + find_known(group, kept));
}

/* The first failure since the last call, when it was, and of which strand. */
int read_failure(Group *group, double *time, int *strand) {
    int found = group->failure;
    *time = group->failed_at, *strand = group->fallen;
    group->failure = FINE;
    return found;
}

Group *make_group(const double *weights) {
    Group *group = calloc(1, sizeof(Group));
    if (group) group->weight_end = weights[0], group->weight_start = weights[1], group->weight_before = weights[2];
    return group;
}

/* numbers: length without elongation [m], and force at the start [N]. */
void set_strand(Group *group, int i, int place, const double *numbers, const double *start, const double *parameters) {
    Strand *one = group->strands + i;
    one->step = STEPS[i], one->states = STATES[i], one->place = place;
    one->reference = numbers[0], one->force = numbers[1];
    memcpy(one->start, start, sizeof(double) * (size_t)one->states);
    PREPARES[i](parameters, one->constants);
}
