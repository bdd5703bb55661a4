
/* Every run in a thread of its own, on steps of its own: before this text stands what C compiles for one run. */

KERNEL march_to_ends(const march *given) {
    march m = *given;
    block b;
    const long run = blockIdx.x * (long)blockDim.x + threadIdx.x;
    if (run >= m.runs) return;
    begin_runs(&m, &b, run);
    if (any_live(&b)) begin_step(&m, &b);
    while (any_live(&b)) {
        try_step(&m, &b);
        if (!judge_step(&m, &b)) continue;
        accept_step(&m, &b);
        if (any_live(&b)) begin_step(&m, &b);
    }
}
