// How a call ended, by its number.
export const STATUS = ["ok", "long step", "unsolved", "out of range", "not finite", "bad input"];
const COARSE = 1;
const WHY = {
  2: "the model was not solved to its tolerance; make a shorter step",
  4: "a number became infinite or none",
  5: "an argument is not finite, out of its range, or not the sample time",
};

export class ModelError extends Error {
  constructor(status, lane, doing) {
    super(`Lane ${lane} failed to ${doing}: ${WHY[status]}. Its state is that before.`);
    this.name = "ModelError";
    this.status = STATUS[status];
    this.lane = lane;
  }
}

/** The compiled module: of `NAME.wasm` beside this file, or of a URL, a response, or bytes. */
export async function load(source = new URL("./$NAME.wasm", import.meta.url)) {
  if (source instanceof WebAssembly.Module) return new Program(source);
  if (typeof source === "string" || source instanceof URL) source = await readFrom(new URL(source, import.meta.url));
  if (typeof Response !== "undefined" && source instanceof Response) {
    if (!source.ok) throw new Error(`There is no module at ${source.url}: ${source.status}.`);
    source = await source.arrayBuffer();
  }
  return new Program(await WebAssembly.compile(source));
}

async function readFrom(url) {
  if (url.protocol !== "file:" || typeof process === "undefined") return fetch(url);
  const { readFile } = await import("node:fs/promises");
  return readFile(url);
}

class Program {
  constructor(module) {
    this.module = module;
  }

  /** A model in its own memory, at rest under the signals given. */
  create({ lanes = 1, parameters: values = {}, signals: given = {} } = {}) {
    return new Model(this.module, lanes, values, given);
  }
}

function place(table, kind, name) {
  const known = Object.hasOwn(table, name) ? table[name] : undefined;
  if (!known) throw new RangeError(`There is no ${kind} "${name}". Valid: ${Object.keys(table).join(", ")}.`);
  return known.index;
}

function requireFinite(values) {
  if (!values.every(Number.isFinite)) throw new RangeError("All signals must be finite.");
}

/** How a signal is read at a step, a lane and a time. */
function reader(value, kept, steps, lanes) {
  if (value === undefined) return (k, lane) => kept[lane];
  if (typeof value === "number") return () => value;
  if (typeof value === "function") return (k, lane, time) => value(time, lane);
  return value.length === steps ? (k) => value[k] : (k, lane) => value[k * lanes + lane];
}

function requireCounts(counts) {
  for (const [name, count] of Object.entries(counts))
    if (!Number.isInteger(count) || count < 1)
      throw new RangeError(`"${name}" must be a whole number from 1, but is ${count}.`);
}

class Model {
  #call;
  #heap;
  #at = {};
  #base;

  constructor(module, lanes, values, given) {
    requireCounts({ lanes });
    this.lanes = lanes;
    this.time = 0;
    this.#call = new WebAssembly.Instance(module).exports;
    this.#heap = this.#call.memory;
    this.#base = Math.ceil(this.#call.__heap_base.value / 16) * 16;
    const sizes = { models: SIZE * lanes, signals: INPUTS * lanes, seen: OUTPUTS * lanes, status: lanes, taken: lanes };
    const { end, ...at } = this.#lay({ ...sizes, end: 0 });
    this.#at = at;
    this.#base = end;
    this.#call.defaults(this.#at.models, lanes);
    const now = this.#numbers("signals");
    for (const { index, first } of Object.values(signals)) now.fill(first, index * lanes, (index + 1) * lanes);
    this.set(values);
    this.start(given);
  }

  #reserve(bytes) {
    const pages = Math.ceil((bytes - this.#heap.buffer.byteLength) / 65536);
    if (pages > 0) this.#heap.grow(pages);
  }

  #numbers(name, count = this.#sizes[name] * this.lanes) {
    return new Float64Array(this.#heap.buffer, this.#at[name] ?? name, count);
  }

  get #sizes() {
    return { models: SIZE, signals: INPUTS, seen: OUTPUTS };
  }

  #whole(name, count = this.lanes) {
    return new Int32Array(this.#heap.buffer, this.#at[name] ?? name, count);
  }

  #worst(doing) {
    const status = this.#whole("status");
    const failed = status.findIndex((one) => one > COARSE);
    if (failed >= 0) throw new ModelError(status[failed], failed, doing);
    return STATUS[status.reduce((a, b) => Math.max(a, b), 0)];
  }

  /** Put a number into all lanes, or numbers into one each. */
  #spread(target, begin, stride, value, name) {
    if (typeof value !== "number" && value?.length !== this.lanes)
      throw new RangeError(`"${name}" needs one number, or ${this.lanes} of them, but is ${value}.`);
    for (let lane = 0; lane < this.lanes; lane++)
      target[begin + stride * lane] = typeof value === "number" ? value : value[lane];
  }

  /** Set parameters by name. All are taken, or none; the model goes on from its state. */
  set(values) {
    const before = this.#numbers("models").slice();
    try {
      for (const [name, value] of Object.entries(values))
        this.#spread(this.#numbers("models"), place(parameters, "parameter", name), SIZE, value, name);
      this.#call.prepare(this.#at.models, this.lanes, this.#at.status);
      this.#worst("take these parameters");
    } catch (error) {
      this.#numbers("models").set(before);
      throw error;
    }
  }

  get(name, lane = 0) {
    return this.#numbers("models")[this.#lane(lane) * SIZE + place(parameters, "parameter", name)];
  }

  #lane(lane) {
    if (!Number.isInteger(lane) || lane < 0 || lane >= this.lanes)
      throw new RangeError(`There is no lane ${lane}: there are ${this.lanes}, from 0.`);
    return lane;
  }

  /** Signals stay as they are until they are given anew; all are taken, or none. */
  #give(given) {
    const now = this.#numbers("signals").slice();
    for (const [name, value] of Object.entries(given))
      this.#spread(now, place(signals, "signal", name) * this.lanes, 1, value, name);
    requireFinite(now);
    this.#numbers("signals").set(now);
  }

  /** To rest under the signals, at time 0. */
  start(given = {}) {
    this.#give(given);
    this.#call.start(this.#at.models, this.lanes, this.#at.signals, this.#at.status);
    this.#worst("start");
    this.time = 0;
  }

  /** Go on by dt [s] under constant signals. */
  step(dt, given = {}) {
    this.#give(given);
    this.#call.step(this.#at.models, this.lanes, this.#at.signals, dt, this.#at.status);
    if (this.#whole("status").some((one) => one <= COARSE)) this.time += dt;
    return this.#worst(`go on by ${dt} s`);
  }

  #see() {
    this.#call.observe(this.#at.models, this.lanes, this.#at.signals, this.#at.seen, this.#at.status);
    this.#worst("be observed");
    return this.#numbers("seen");
  }

  /** An output of a lane. */
  read(name, lane = 0) {
    return this.#see()[place(outputs, "output", name) * this.lanes + this.#lane(lane)];
  }

  /** An output of every lane. */
  column(name) {
    const begin = place(outputs, "output", name) * this.lanes;
    return this.#see().slice(begin, begin + this.lanes);
  }

  /** All outputs of a lane by name. */
  observe(lane = 0) {
    const seen = this.#see();
    this.#lane(lane);
    const row = Object.entries(outputs).map(([name, { index }]) => [name, seen[index * this.lanes + lane]]);
    return Object.fromEntries(row);
  }

  /**
   * Many steps in one call. `dt` is a length [s] or one for every step; a signal is a number, an array
   * of one number a step (or steps × lanes, lane by lane within a step), or a function of the time at
   * which a step begins and of the lane. Columns hold rows × lanes, lane by lane within a row.
   */
  run({ dt, steps = dt?.length, signals: given = {}, outputs: wanted, every = 1, failures = "throw" }) {
    requireCounts({ steps, every });
    if (typeof dt !== "number" && dt?.length !== steps)
      throw new RangeError(`"dt" needs one number, or ${steps} of them.`);
    const names = wanted ?? Object.keys(outputs);
    const places = names.map((name) => place(outputs, "output", name));
    const { lanes } = this;
    const [rows, row] = [Math.ceil(steps / every), places.length * lanes];
    const sizes = { dt: steps, signals: steps * INPUTS * lanes, places: places.length, rows: rows * row };
    const at = this.#lay(sizes);
    const lengths = this.#numbers(at.dt, steps);
    typeof dt === "number" ? lengths.fill(dt) : lengths.set(dt);
    const played = this.#numbers(at.signals, steps * INPUTS * lanes);
    this.#play(played, lengths, given);
    this.#whole(at.places, places.length).set(places);
    const { models, status, taken } = this.#at;
    const chosen = [places.length, at.places, at.rows];
    this.#call.run(models, lanes, steps, at.dt, at.signals, every, ...chosen, status, taken);
    this.#numbers("signals").set(played.subarray((steps - 1) * INPUTS * lanes));
    const counts = this.#whole("taken").slice();
    const time = this.#times(lengths, every, counts.reduce((a, b) => Math.max(a, b), 0));
    if (failures === "throw") this.#worst(`run for ${steps} steps`);
    const columns = this.#columns(names, this.#numbers(at.rows, rows * row));
    return { time, columns, status: Array.from(this.#whole("status"), (one) => STATUS[one]), steps: counts };
  }

  /** Where so many numbers of each kind lie above the model; the memory is made to hold them. */
  #lay(sizes) {
    const at = {};
    let free = this.#base;
    for (const [name, size] of Object.entries(sizes)) {
      at[name] = free;
      free += 8 * size;
    }
    this.#reserve(free);
    return at;
  }

  #columns(names, seen) {
    const { lanes } = this;
    const found = names.map(() => new Float64Array(names.length && seen.length / names.length));
    for (let k = 0; k < seen.length; k++) {
      const [row, inside] = [Math.floor(k / (names.length * lanes)), k % (names.length * lanes)];
      found[Math.floor(inside / lanes)][row * lanes + (inside % lanes)] = seen[k];
    }
    return Object.fromEntries(names.map((name, k) => [name, found[k]]));
  }

  /** Times of the rows; that of the model becomes that of the lane that came farthest. */
  #times(lengths, every, taken) {
    const times = [];
    let time = this.time;
    lengths.forEach((length, k) => {
      time += length;
      if (k < taken) this.time = time;
      if ((k + 1) % every === 0 || k + 1 === lengths.length) times.push(time);
    });
    return Float64Array.from(times);
  }

  /** Write the signals of all steps; one that is not given stays as it is. */
  #play(target, lengths, given) {
    const [{ lanes }, steps] = [this, lengths.length];
    for (const [name, value] of Object.entries(given)) {
      place(signals, "signal", name);
      if (typeof value === "object" && value.length !== steps && value.length !== steps * lanes)
        throw new RangeError(`"${name}" needs ${steps} numbers, or ${steps * lanes}, but has ${value.length}.`);
    }
    const now = this.#numbers("signals");
    for (const [name, { index }] of Object.entries(signals)) {
      const kept = now.slice(index * lanes, (index + 1) * lanes);
      const read = reader(given[name], kept, steps, lanes);
      for (let k = 0, time = this.time; k < steps; time += lengths[k++])
        for (let lane = 0; lane < lanes; lane++) target[(k * INPUTS + index) * lanes + lane] = read(k, lane, time);
    }
    requireFinite(target);
  }

  /** All numbers of the model, to go back to. */
  save() {
    const saved = new Float64Array(3 + (SIZE + INPUTS) * this.lanes);
    saved.set([TAG, this.lanes, this.time]);
    saved.set(this.#numbers("signals"), 3);
    saved.set(this.#numbers("models"), 3 + INPUTS * this.lanes);
    return saved;
  }

  restore(saved) {
    const middle = 3 + INPUTS * this.lanes;
    if (saved.length !== middle + SIZE * this.lanes || saved[0] !== TAG || saved[1] !== this.lanes)
      throw new RangeError("These numbers were not saved by this model with as many lanes.");
    this.time = saved[2];
    this.#numbers("signals").set(saved.subarray(3, middle));
    this.#numbers("models").set(saved.subarray(middle));
  }
}
