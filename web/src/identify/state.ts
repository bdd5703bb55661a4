// What the reader has chosen on the way to a fit; kept in the session, with the file.

import { computed, signal } from "@preact/signals";
import { call, isThere, sentence, superseded, type Uploaded, upload } from "../lib/api.ts";
import { connection } from "../lib/connection.ts";
import { keepFile, readFile } from "../lib/store.ts";
import { makeId } from "../lib/tab.ts";
import { watched } from "../state/jobs.ts";
import { keepSignals } from "../state/session.ts";
import type { Note, Outcome, RecordsView, ScenarioView, TableView } from "./types.ts";

export const STEPS = ["File", "Records", "Scenario", "Fit", "Result"] as const;

export interface Column {
  at: number;
  name: string;
  unit: string;
  /** Whether name or unit are as guessed from the heading. */
  guessed: boolean;
}

export interface Cut {
  name: string;
  /** [s] */
  from: number;
  to: number;
  /** Every so many rows. */
  every: number;
  /** Whether it is kept back from the fit. */
  held: boolean;
}

/** Start and bounds in SI; null for what the library chooses. */
export interface Choice {
  start: number | null;
  low: number | null;
  high: number | null;
}

export interface State {
  step: number;
  /** Its key on the server, and that of its content in the browser; the measured one of the package has none. */
  file: { key: string; name: string; bytes: number; content?: string } | null;
  separator: string;
  drop: boolean;
  /** Time between rows [s], where no column is the time. */
  interval: number | null;
  columns: Column[];
  cuts: Cut[];
  /** The scenario: TOML, and where it is from. */
  text: string;
  origin: string;
  free: Record<string, Choice>;
  each: string[];
  /** Outputs that are not compared though they could be. */
  ignored: string[];
  method: string;
  loss: string;
  starts: number;
  holdOut: string;
  /** The job whose outcome was thrown away. */
  dropped: string;
}

const EMPTY: State = {
  step: 0, file: null, separator: "auto", drop: false, interval: null, columns: [], cuts: [], text: "", origin: "",
  free: {}, each: [], ignored: [], method: "trf", loss: "linear", starts: 0, holdOut: "auto", dropped: "",
};

export const state = signal<State>(EMPTY);
keepSignals("identify", { state });
export const put = (patch: Partial<State>): void => void (state.value = { ...state.value, ...patch });

export const table = signal<TableView | null>(null);
export const records = signal<RecordsView | null>(null);
export const scenario = signal<ScenarioView | null>(null);
export const refused = signal("");
export const busy = signal("");

export const fitting = watched<Note, Outcome>("fit");
export const reporting = watched<Note, { key: string; name: string }>("fit_files");

/** The table and its meaning, as the server takes them. */
export const logRequest = computed(() => {
  const { file, separator, drop, interval, columns, cuts } = state.value;
  return {
    key: file?.key ?? "",
    separator,
    drop,
    interval: columns.some((one) => one.name === "time") ? null : interval,
    columns: columns.filter((one) => one.name).map(({ at, name, unit }) => ({ at, name, unit })),
    cuts: cuts.map(({ name, from, to, every }) => ({ name, from, to, every })),
  };
});

/** All that is asked of the fit. */
export const fitRequest = computed(() => {
  const { text, free, each, ignored, method, loss, starts, holdOut, cuts } = state.value;
  const outputs = scenario.value?.outputs.map((one) => one.name) ?? [];
  const compare = outputs.filter((name) => !ignored.includes(name));
  const held = cuts.filter((one) => one.held).map((one) => one.name);
  return {
    ...logRequest.value,
    text,
    free: Object.entries(free).map(([name, choice]) => ({ name, ...choice })),
    each: each.map((name) => ({ name })),
    compare: compare.length === outputs.length ? [] : compare,
    hold_out: held.length ? held : holdOut,
    method,
    loss,
    starts,
  };
});

/** Bring the file to the server again if that has forgotten it; whether it had. */
export async function restoreFile(): Promise<boolean> {
  const { file } = state.value;
  if (!file || connection.value !== "there" || (await isThere(file.key))) return false;
  const content = file.content && (await readFile(file.content));
  if (file.content && !content) return false;
  const found = content ? await upload(new File([content], file.name)) : await call<Uploaded>("sample_log", {});
  if (state.value.file?.key !== file.key) return false;
  put({ file: { ...file, key: found.key } });
  return true;
}

/** Ask the server; what it refuses is told, and gives null. */
export async function asked<T>(name: string, request: object, words: string): Promise<T | null> {
  busy.value = words;
  const before = state.value.file?.key;
  try {
    const found = await call<T>(name, request, `identify ${name}`);
    refused.value = "";
    return found;
  } catch (error) {
    if (superseded(error)) return null;
    if (before && (request as { key?: string }).key === before && (await restoreFile())) return asked(name, { ...request, key: state.value.file?.key }, words);
    refused.value = sentence(error);
    return null;
  } finally {
    busy.value = "";
  }
}

/** Look at a file; `fresh` takes over what is guessed of its columns. */
export async function readTable(fresh: boolean): Promise<void> {
  const { file, separator } = state.value;
  if (!file) return;
  const found = await asked<TableView>("table", { key: file.key, separator }, "Reading the file …");
  table.value = found;
  if (found && (fresh || state.value.columns.length !== found.columns.length)) {
    const columns = found.columns.map(({ name, unit }, at) => ({ at, name, unit, guessed: true }));
    put({ columns, cuts: [] });
    reading.request = "";
    records.value = scenario.value = null;
  }
}

/** Begin with a file of the reader, one that the server has, or the measured log that comes with the package; a scenario may come along. */
export async function takeFile(file: File | Uploaded | "sample", text = ""): Promise<void> {
  busy.value = "Uploading …";
  try {
    const found =
      file === "sample" ? await call<Uploaded>("sample_log", {}) : "key" in file ? file : { ...(await upload(file)), content: await keepContent(file) };
    reading.request = "";
    table.value = records.value = scenario.value = null;
    // the measured one is a slow loop without times: any will do
    const interval = file === "sample" ? 1 : null;
    put({ file: found, separator: "auto", drop: false, interval, columns: [], cuts: [], step: 0, ...(text && { text, origin: "the board", free: {}, ignored: [], each: [] }) });
    await readTable(true);
  } catch (error) {
    refused.value = sentence(error);
  } finally {
    busy.value = "";
  }
}

async function keepContent(file: File): Promise<string> {
  const key = makeId();
  await keepFile(key, file).catch(() => undefined); // no room: it is lost with the server
  return key;
}

let reading = { request: "", done: Promise.resolve(false) };

/** The columns as they are mapped and cut now; asked for once, whoever waits for them. */
export function readRecords(): Promise<boolean> {
  const request = JSON.stringify(logRequest.value);
  if (reading.request === request) return reading.done;
  const done = asked<RecordsView>("fit_records", logRequest.value, "Reading the columns …").then((found) => {
    if (found) records.value = found;
    else if (reading.request === request) reading.request = "";
    return found !== null;
  });
  reading = { request, done };
  return done;
}

/** Look at the scenario beside the log; a drive may be made to follow a column. */
export async function readScenario(follow: { path: string; column: string } | null = null): Promise<void> {
  const { text } = state.value;
  if (!text) return;
  const found = await asked<ScenarioView>("fit_scenario", { ...logRequest.value, text, ...(follow ? { follow } : {}) }, "Reading the scenario …");
  if (!found) return;
  scenario.value = found;
  const known = new Set(found.numbers.map((one) => one.name));
  const free = Object.fromEntries(Object.entries(state.value.free).filter(([name]) => !known.size || known.has(name)));
  put({ text: found.text, free });
}

/** Go to a step, once what it shows has been read. */
export async function goTo(step: number): Promise<void> {
  refused.value = "";
  if (step === 0 && !table.value) await readTable(false);
  if (step >= 1 && step <= 3 && !(await readRecords())) return;
  if (step === 1 && !state.value.cuts.length && records.value) put({ cuts: [wholeCut()] });
  if (step === 2 || (step === 3 && !scenario.value)) await readScenario();
  put({ step });
}

const MANY = 4000;

/** The whole log as one record, thinned out if it is long. */
export function wholeCut(): Cut {
  const { begin = 0, end = 0, rows = 0 } = records.value ?? {};
  const count = state.value.cuts.length;
  const name = (state.value.file?.name ?? "log").replace(/\.\w+$/, "") + (count ? `-${count + 1}` : "");
  return { name, from: begin, to: end, every: Math.max(1, Math.ceil(rows / MANY)), held: false };
}

export const isRunning = computed(() => fitting.job.value?.state === "running");

export async function beginFit(further: object = {}): Promise<void> {
  refused.value = "";
  put({ dropped: "", step: 3 });
  fitting.job.value = null;
  await restoreFile();
  await fitting.begin({ ...fitRequest.value, ...further });
}

/** End the fit; its best so far is kept, or thrown away. */
export async function endFit(keep: boolean): Promise<void> {
  if (!keep) put({ dropped: fitting.job.value?.id ?? "" });
  await fitting.cancel(keep);
  // a process that did not end in time was ended by force: its best so far is in the state of its search
  if (keep && fitting.job.value?.state === "cancelled" && bestKept.value) await beginFit({ state: bestKept.value, finish: true });
}

export const bestKept = computed(() => fitting.job.value?.trail.find((note) => note.problem)?.problem?.state ?? "");

/** The outcome, if there is one that was not thrown away. */
export const outcome = computed((): Outcome | null => {
  const job = fitting.job.value;
  const found = job?.outcome;
  return job?.state === "done" && job.id !== state.value.dropped && found && typeof found === "object" ? found : null;
});
