
/* Every run in a thread of its own, on steps of its own: before this text stands what C compiles for one run. */

KERNEL march_to_ends(const march *given) {
    march m = *given;
    block b;
    const long run = blockIdx.x * (long)blockDim.x + threadIdx.x;
    if (run >= m.runs) return;
    begin_block(&m, &b, run, run + 1);
    while (go_on(&m, &b) != DONE) continue;
}
