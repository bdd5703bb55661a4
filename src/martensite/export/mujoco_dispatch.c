/* The one callback of MuJoCo for the biases of all models of a process: biasprm[0] says whose the actuator is. */

typedef double (*Force)(void *, const mjModel *, const mjData *, int);

static Force forces[MOST];
static void *groups[MOST];
static int known;

/* A number from 1 on, or 0 if there are too many. */
int add_group(Force force, void *group) {
    if (known + 1 >= MOST) return 0;
    known++;
    forces[known] = force, groups[known] = group;
    return known;
}

double find_bias(const mjModel *m, const mjData *d, int id) {
    int number = (int)m->actuator_biasprm[id * mjNBIAS];
    if (number < 1 || number > known) return NAN;
    return forces[number](groups[number], m, d, id);
}
