// What the reader has chosen on the way to a fit; kept in the session, with the file.

import { computed, signal } from "@preact/signals";
import { call, isThere, sentence, superseded, type Uploaded, upload } from "../lib/api.ts";
import { connection } from "../lib/connection.ts";
import { keepFile, readFile } from "../lib/store.ts";
import { makeId } from "../lib/identity.ts";
import { watched } from "../state/jobs.ts";
import { keepSignals } from "../state/session.ts";
import type { Note, Outcome, OverlayView, ProposalView, ProposedModel, RecordsView, ScenarioView, TableView } from "./types.ts";

export const STEPS = ["File", "Records", "Scenario", "Fit", "Result"] as const;

export interface Column {
  at: number;
  name: string;
  unit: string;
  /** The numbers of the file are multiplied by it, such as 2 for 2 mm per volt; null for 1. */
  factor?: number | null;
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
  scale?: string | null;
}

/** Something that is done to a log before it is fitted; see martensite.app.identify.preparation. */
export interface Step {
  kind: "smooth" | "median" | "outliers" | "zero" | "offset" | "resample" | "cut" | "hold";
  column?: string;
  width?: number;
  limit?: number;
  rows?: number;
  value?: number;
  interval?: number;
  from?: number;
  to?: number;
}

/** One log: its file, what its columns mean, what is done to it, and its records. */
export interface LogState {
  /** Its key on the server, and that of its content in the browser; the measured one of the package has none. */
  file: { key: string; name: string; bytes: number; content?: string } | null;
  separator: string;
  drop: boolean;
  /** Time between rows [s], where no column is the time. */
  interval: number | null;
  columns: Column[];
  steps: Step[];
  cuts: Cut[];
  /** Whether its columns join those of the first log, and how much later it began [s]; null for what clocks and quantities say. */
  merge: boolean;
  shift: number | null;
}

/** The log that is looked at is spread out in it; the others wait in `others`, which lacks the place `at`. */
export interface State extends LogState {
  step: number;
  others: LogState[];
  at: number;
  align: "start" | "clock";
  /** The proposed scenario that was taken. */
  proposed: string;
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

const NO_LOG: LogState = { file: null, separator: "auto", drop: false, interval: null, columns: [], steps: [], cuts: [], merge: false, shift: null };

const EMPTY: State = {
  ...NO_LOG, step: 0, others: [], at: 0, align: "start", proposed: "", text: "", origin: "",
  free: {}, each: [], ignored: [], method: "trf", loss: "linear", starts: 0, holdOut: "auto", dropped: "",
};

const kept = signal<State>(EMPTY);
keepSignals("identify", { state: kept });
/** Sessions of before know of one log only. */
export const state = computed<State>(() => ({ ...EMPTY, ...kept.value }));
export const put = (patch: Partial<State>): void => void (kept.value = { ...state.peek(), ...patch });

const bare = (one: LogState): LogState => ({
  file: one.file, separator: one.separator, drop: one.drop, interval: one.interval, columns: one.columns, steps: one.steps, cuts: one.cuts, merge: one.merge, shift: one.shift,
});

/** All logs in their order. */
export const logs = computed((): LogState[] => {
  const { others, at, file } = state.value;
  return file ? [...others.slice(0, at), bare(state.value), ...others.slice(at)] : [];
});

/** Take over a list of logs, of which one is looked at. */
function putLogs(list: LogState[], at: number): void {
  const { [at]: one = NO_LOG } = list;
  put({ ...one, others: list.filter((_, k) => k !== at), at: Math.min(at, Math.max(0, list.length - 1)) });
}

export const table = signal<TableView | null>(null);
export const records = signal<RecordsView | null>(null);
export const overlay = signal<OverlayView | null>(null);
export const proposal = signal<ProposalView | null>(null);
export const scenario = signal<ScenarioView | null>(null);
export const refused = signal("");
export const busy = signal("");

export const fitting = watched<Note, Outcome>("fit");
export const reporting = watched<Note, { key: string; name: string }>("fit_files");

/** A table and its meaning, as the server takes them. */
const asRequest = ({ file, separator, drop, interval, columns, steps, cuts, merge, shift }: LogState) => ({
  key: file?.key ?? "",
  separator,
  drop,
  interval: columns.some((one) => one.name === "time") ? null : interval,
  columns: columns.filter((one) => one.name).map(({ at, name, unit, factor }) => ({ at, name, unit, ...(factor == null ? {} : { factor }) })),
  steps,
  cuts: cuts.map(({ name, from, to, every }) => ({ name, from, to, every })),
  merge,
  shift,
});

/** The log that is looked at, with what is merged into it. */
export const ownRequest = computed(() => {
  const [first, ...more] = logs.value;
  const own = asRequest(state.value);
  const isFirst = first !== undefined && state.value.at === 0;
  return { ...own, further: isFirst ? more.filter((one) => one.merge).map(asRequest) : [] };
});

/** All logs. */
export const logRequest = computed(() => {
  const [first = NO_LOG, ...more] = logs.value;
  return { ...asRequest(first), further: more.map(asRequest) };
});

/** Names of the records that are held out whole. */
export const heldNames = computed(() => logs.value.flatMap((log) => log.cuts.filter((one) => one.held).map((one) => one.name)));

/** All that is asked of the fit. */
export const fitRequest = computed(() => {
  const { text, free, each, ignored, method, loss, starts, holdOut, proposed } = state.value;
  const outputs = scenario.value?.outputs.map((one) => one.name) ?? [];
  const compare = outputs.filter((name) => !ignored.includes(name));
  const held = heldNames.value;
  return {
    ...logRequest.value,
    proposed,
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
  let some = false;
  if (connection.value !== "there") return some;
  for (const { file } of logs.value) {
    if (!file || (await isThere(file.key))) continue;
    const content = file.content && (await readFile(file.content));
    if (file.content && !content) continue;
    const load = Number(/(\d+)MPa/.exec(file.name)?.[1] ?? 172);
    const found = content ? await upload(new File([content], file.name)) : await call<Uploaded>("sample_log", { load });
    const renewed = logs.value.map((one) => (one.file?.key === file.key ? { ...one, file: { ...file, key: found.key } } : one));
    putLogs(renewed, state.value.at);
    some = true;
  }
  return some;
}

/** Ask the server; what it refuses is told, and gives null. */
export async function asked<T>(name: string, request: object, words: string): Promise<T | null> {
  busy.value = words;
  const before = logs.value.map((one) => one.file?.key);
  try {
    const found = await call<T>(name, request, `identify ${name}`);
    refused.value = "";
    return found;
  } catch (error) {
    if (superseded(error)) return null;
    if (before.includes((request as { key?: string }).key) && (await restoreFile())) return asked(name, renewed(request, before), words);
    refused.value = sentence(error);
    return null;
  } finally {
    busy.value = "";
  }
}

/** A request with the keys that its files have now. */
function renewed(request: object, before: (string | undefined)[]): object {
  let text = JSON.stringify(request);
  before.forEach((key, k) => (text = key ? text.replaceAll(key, logs.value[k]?.file?.key ?? key) : text));
  return JSON.parse(text) as object;
}

/** Look at a file; `fresh` takes over what is guessed of its columns. */
export async function readTable(fresh: boolean): Promise<void> {
  const { file, separator } = state.value;
  if (!file) return;
  const found = await asked<TableView>("table", { key: file.key, separator }, "Reading the file …");
  table.value = found;
  if (found && (fresh || state.value.columns.length !== found.columns.length)) {
    put({ columns: guessed(found), cuts: [], steps: [] });
    forget();
  }
}

/** What was read of the logs before something about them changed. */
function forget(): void {
  reading.request = "";
  records.value = scenario.value = overlay.value = proposal.value = null;
}

/** A file of the reader, one that the server has, or a measured one that comes with the package, by its stress [MPa]. */
export type Given = File | Uploaded | number;

/** Start again with a file, or with several; a scenario may come along. */
export async function takeFile(file: Given | Given[], text = ""): Promise<void> {
  put({ ...NO_LOG, others: [], at: 0, step: 0, proposed: "", ...(text && { text, origin: "the board", free: {}, ignored: [], each: [] }) });
  table.value = null;
  await addFiles(Array.isArray(file) ? file : [file]);
}

const guessed = (of: TableView): Column[] => of.columns.map(({ name, unit }, at) => ({ at, name, unit, guessed: true }));

async function placed(file: Given): Promise<NonNullable<LogState["file"]>> {
  if (typeof file === "number") return call<Uploaded>("sample_log", { load: file });
  return "key" in file ? file : { ...(await upload(file)), content: await keepContent(file) };
}

/** Further logs beside those that are there; what is refused takes none of them. */
export async function addFiles(files: Given[], held = false): Promise<void> {
  if (!files.length) return;
  busy.value = "Reading …";
  try {
    refused.value = "";
    const taken = await Promise.all(files.map(placed));
    const place = logs.value.length;
    // a single file that cannot be read stays, for another separator may help
    if (taken.length === 1 && place === 0) {
      putLogs([{ ...NO_LOG, file: taken[0]! }], 0);
      await readTable(true);
      return;
    }
    const tables = await Promise.all(taken.map(({ key }) => call<TableView>("table", { key, separator: "auto" })));
    forget();
    putLogs([...logs.value, ...taken.map((file, k) => ({ ...NO_LOG, file, columns: guessed(tables[k]!) }))], place);
    table.value = tables[0] ?? null;
    if (held) await nameRecord(held);
  } catch (error) {
    refused.value = sentence(error);
  } finally {
    busy.value = "";
  }
}

/** A whole log as one record that may be held out. */
async function nameRecord(held: boolean): Promise<void> {
  if (held && (await readRecords())) put({ cuts: [{ ...wholeCut(), held }] });
}

/** Look at another log. */
export async function chooseLog(at: number): Promise<void> {
  if (at === state.value.at) return;
  putLogs(logs.value, at);
  table.value = records.value = null;
  reading.request = "";
  await readTable(false);
  if (state.value.step === 1) await readCuts();
}

export async function removeLog(at: number): Promise<void> {
  const rest = logs.value.filter((_, k) => k !== at);
  putLogs(rest.map((one, k) => (k === 0 ? { ...one, merge: false } : one)), Math.max(0, Math.min(state.value.at - (at <= state.value.at ? 1 : 0), rest.length - 1)));
  forget();
  table.value = null;
  await readTable(false);
  await readOverlay();
}

/** Change a log that need not be the one that is looked at. */
export async function changeLog(at: number, patch: Partial<LogState>): Promise<void> {
  putLogs(logs.value.map((one, k) => (k === at ? { ...one, ...patch } : one)), state.value.at);
  forget();
  await readOverlay();
}

export async function readOverlay(): Promise<void> {
  if (!logs.value.length) return void (overlay.value = null);
  const found = await asked<OverlayView>("log_overlay", { ...logRequest.value, align: state.value.align }, "Drawing the logs …");
  if (found) overlay.value = found;
}

/** What the logs are taken for, and which scenarios may explain them. */
export async function readProposal(): Promise<ProposalView | null> {
  const found = await asked<ProposalView>("fit_proposal", logRequest.value, "Looking for a model …");
  if (found) proposal.value = found;
  return found;
}

let asking = 0;

/** Look for a model of columns that the reader has changed, once the changes pause. */
export function proposeSoon(): void {
  proposal.value = null;
  clearTimeout(asking);
  asking = window.setTimeout(() => void proposeQuietly(), 400);
}

/** Look for a model without touching what was refused elsewhere. */
async function proposeQuietly(): Promise<void> {
  try {
    proposal.value = await call<ProposalView>("fit_proposal", logRequest.value, "identify fit_proposal");
  } catch (error) {
    if (!superseded(error)) proposal.value = { kind: "", said: "", refused: sentence(error), notes: [], models: [] };
  }
}

/** What the page takes the logs for, and whether a model can be fitted. */
export const understood = computed(() => {
  const [found, now] = [table.value, proposal.value];
  const isOwn = state.value.columns.some((one) => one.name && !one.guessed);
  if (now) return { said: now.refused || now.said, isKnown: !now.refused };
  if (isOwn) return { said: "", isKnown: false };
  return { said: found?.said ?? "", isKnown: (found?.recognised ?? false) || logs.value.length > 1 };
});

/** The proposal with the fewest free numbers. */
export const simplest = (of: ProposalView): ProposedModel | undefined => [...of.models].sort((a, b) => a.free.length - b.free.length)[0];

export async function takeModel(model: ProposedModel): Promise<void> {
  const free = Object.fromEntries(model.free.map(({ name, low, high, start, scale }) => [name, { start, low, high, scale }]));
  scenario.value = null;
  put({ text: model.text, origin: `the proposal ${model.name}`, proposed: model.name, free, each: model.each, ignored: [], starts: model.starts });
  await readScenario();
}

/** From the logs to a fit at once, with the simplest scenario that is proposed. */
export async function fitProposed(): Promise<void> {
  const found = await readProposal();
  const model = found && simplest(found);
  if (!model) return void (found?.refused && (refused.value = found.refused));
  await takeModel(model);
  if (!model.free.length) return goTo(2); // nothing speaks for any number: that is for the reader to say
  if (scenario.value && !scenario.value.refused) await beginFit();
}

async function keepContent(file: File): Promise<string> {
  const key = makeId();
  await keepFile(key, file).catch(() => undefined); // no room: it is lost with the server
  return key;
}

let reading = { request: "", done: Promise.resolve(false) };

/** The columns as they are mapped and cut now; asked for once, whoever waits for them. */
export function readRecords(): Promise<boolean> {
  const request = JSON.stringify(ownRequest.value);
  if (reading.request === request) return reading.done;
  const done = asked<RecordsView>("fit_records", ownRequest.value, "Reading the columns …").then((found) => {
    if (found) records.value = found;
    else if (reading.request === request) reading.request = "";
    return found !== null;
  });
  reading = { request, done };
  return done;
}

/** Look at the scenario beside the log; a drive may be made to follow a column. */
export async function readScenario(follow: { path: string; column: string } | null = null): Promise<void> {
  const { text, proposed } = state.value;
  if (!text) return;
  const found = await asked<ScenarioView>("fit_scenario", { ...logRequest.value, text, proposed, ...(follow ? { follow } : {}) }, "Reading the scenario …");
  if (!found) return;
  scenario.value = found;
  const known = new Set(found.numbers.map((one) => one.name));
  const free = Object.fromEntries(Object.entries(state.value.free).filter(([name]) => !known.size || name.split(/-(?=[A-Z])/).every((part) => known.has(part))));
  put({ text: found.text, free });
}

/** Go to a step, once what it shows has been read. */
export async function goTo(step: number): Promise<void> {
  refused.value = "";
  if (step === 0 && !table.value) await readTable(false);
  if (step >= 1 && step <= 3 && !(await readRecords())) return;
  if (step === 1) await readCuts();
  if (step === 2 && !proposal.value) await readProposal();
  if (step === 2 || (step === 3 && !scenario.value)) await readScenario();
  put({ step });
}

/** The records of the log that is looked at, and all logs in one picture. */
async function readCuts(): Promise<void> {
  if (!(await readRecords())) return;
  if (!state.value.cuts.length && records.value) put({ cuts: [wholeCut()] });
  if (!overlay.value) await readOverlay();
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
