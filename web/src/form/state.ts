// The form of the scenario on the bench, and how its controls change it.
//
// Numbers are tried by running them: one request at a time, at the end always the newest value. A
// drag of a slider is one step to undo. Kinds and whole documents go through the call `form`.

import { batch, effect, signal } from "@preact/signals";
import { call, sentence, superseded } from "../lib/api.ts";
import { refused, run, tryChanges } from "../state/run.ts";
import { change, text } from "../state/scenario.ts";
import { keepPart } from "../state/session.ts";
import { patchForm } from "./patch.ts";
import type { ScenarioForm, NumberNode, SingleNode, SliderRange } from "./types.ts";

export const form = signal<ScenarioForm | null>(null);
/** Why there is no form of the document. */
export const trouble = signal("");
export const search = signal("");
/** What was assumed or dropped with the last kind that was chosen. */
export const notes = signal<string[]>([]);
/** Numbers that a kind still needs, and the changes that wait for them. */
export const wanting = signal<{ sentence: string; missing: SingleNode[]; changes: Record<string, unknown> } | null>(null);
/** Counts how often the document went back to what the form shows: what was tried is void then. */
export const returns = signal(0);
/** Path -> sentence of the value that was refused there. */
export const refusals = signal<Record<string, string>>({});

type Changes = Record<string, unknown>;

/** From a change made here to the request of its form [ms]: where the page follows the change itself, and elsewhere. */
const [CALM, SOON] = [3000, 250];

/** The newest form of the server, and its document. */
let described: ScenarioForm | null = null;
let shown = "";
/** Ends of sliders, kept while the form is worked with, so that they do not move under the hand. */
const ranges = new Map<string, SliderRange>();
let waiting = 0;

export function rangeOf(node: NumberNode): SliderRange | null {
  const kept = ranges.get(`${node.path} ${node.unit}`);
  const value = node.value;
  if (kept && value !== null && value >= kept.low && value <= kept.high) return kept;
  if (node.slider) ranges.set(`${node.path} ${node.unit}`, node.slider);
  return node.slider;
}

function show(found: ScenarioForm): void {
  batch(() => {
    form.value = described = found;
    unpatched = {};
    trouble.value = "";
    shown = found.text ?? shown;
  });
}

async function ask(document: string): Promise<void> {
  try {
    const found = await call<ScenarioForm>("form", { text: document }, "form");
    if (document === text.value) show(found);
  } catch (error) {
    if (superseded(error) || document !== text.value) return;
    batch(() => {
      form.value = null;
      trouble.value = sentence(error);
    });
  }
}

/** Keep the form in step with the document, whoever changes it. */
export function followForm(): () => void {
  return effect(() => {
    const now = text.value;
    clearTimeout(waiting);
    if (now === shown && described) {
      unpatched = {};
      form.value = described;
      returns.value = returns.peek() + 1;
    }
    if (!now || now === shown) return;
    const own = sent.has(now);
    if (!own) forget();
    waiting = window.setTimeout(() => void ask(now), now === followed ? CALM : own ? SOON : 0);
  });
}

/** Another document has come: nothing of what was tried before holds. */
function forget(): void {
  ranges.clear();
  sent.clear();
  unpatched = {};
  refusals.value = {};
  notes.value = [];
  wanting.value = null;
}

// ---------------------------------------------------------------- whole documents

/** Put a document in place if it can be built; the sentence of what was wrong, or nothing. */
export function load(document: string): Promise<string> {
  return through({ text: document });
}

/** Choose another kind, or leave entries to the material or their defaults. */
export function restructure(changes: Changes, removed: string[] = []): Promise<string> {
  return through({ text: text.value, changes, removed });
}

async function through(request: { text: string; changes?: Changes; removed?: string[] }): Promise<string> {
  try {
    const found = await call<ScenarioForm>("form", request, "form");
    if (found.text === null) {
      wanting.value = { sentence: found.refused, missing: found.missing, changes: request.changes ?? {} };
      return "";
    }
    const next = found.text;
    batch(() => {
      forget();
      show(found);
      refused.value = "";
      notes.value = [...found.notes, ...assumed(found)];
      change(next);
    });
    return "";
  } catch (error) {
    return superseded(error) ? "" : sentence(error);
  }
}

function assumed(found: ScenarioForm): string[] {
  if (found.assumed.length === 0) return [];
  const names = found.assumed.map((path) => path.split(".").slice(-2).join(" ").replaceAll("_", " "));
  return [`Assumed start values without a source: ${names.join(", ")}.`];
}

// ---------------------------------------------------------------- numbers

/** Documents that came of changes made here, the newest of them. */
const sent = new Set<string>();
const MOST_SENT = 256;

/** Accepted changes that the form does not show yet, and the document to which they lead from there; empty for others. */
let unpatched: Changes = {};
let followed = "";

/** Take a document that came of changes; the form follows once no newer value is on its way. */
function note(document: string, changes: Changes): void {
  sent.add(document);
  if (sent.size > MOST_SENT) sent.delete(sent.values().next().value!);
  unpatched = { ...unpatched, ...changes };
  const next = form.peek() && patchForm(form.peek()!, unpatched, document);
  followed = next ? document : "";
  if (!next || pending) return;
  form.value = next;
  unpatched = {};
}

let busy = false;
let pending: { changes: Changes; drag: number } | null = null;
let drag = 0;
let dragged = { path: "", at: 0, taken: false };

/** What was asked for and is not answered yet; a reload asks for it again. */
const wished = signal<Changes>({});
keepPart(
  "wished",
  () => wished.value,
  (kept) => {
    if (!Object.keys(kept as Changes).length) return;
    wished.value = kept as Changes;
    const end = effect(() => {
      if (!run.value) return; // what was on the bench comes first
      queueMicrotask(() => (end(), send(kept as Changes)));
    });
  },
);

/** Try numbers; the newest of each waits until the last request is answered. */
export function send(changes: Changes, ofDrag = 0): void {
  pending = { changes: { ...pending?.changes, ...changes }, drag: ofDrag };
  wished.value = { ...wished.value, ...changes };
  if (!busy) void pump();
}

/** A value of a slider in motion. */
export function slide(path: string, value: unknown): void {
  const now = performance.now();
  if (path !== dragged.path || now - dragged.at > 1000) {
    drag += 1;
    dragged = { path, at: now, taken: false };
  }
  dragged.at = now;
  send({ [path]: value }, drag);
}

/** The hand takes a slider anew. */
export const grip = (): void => void (dragged.path = "");

/** Go to another document of this session: what a slider still waits to try belongs to this one. */
export function leave(go: () => void): void {
  pending = null;
  wished.value = {};
  grip();
  go();
}

async function pump(): Promise<void> {
  busy = true;
  while (pending) {
    const mine: { changes: Changes; drag: number } = pending;
    pending = null;
    const merge = mine.drag > 0 && mine.drag === drag && dragged.taken;
    const taken = await tryChanges(mine.changes, merge, (document) => note(document, mine.changes));
    if (taken) {
      if (mine.drag === drag) dragged.taken = true;
    }
    settle(Object.keys(mine.changes), taken ? "" : refused.value);
  }
  busy = false;
}

function settle(paths: string[], words: string): void {
  const next = { ...refusals.value };
  wished.value = Object.fromEntries(Object.entries(wished.value).filter(([path]) => pending?.changes[path] !== undefined || !paths.includes(path)));
  for (const path of paths) {
    if (words) next[path] = words;
    else delete next[path];
  }
  refusals.value = next;
}

/** Give a refused value up. */
export function giveUp(path: string): void {
  settle([path], "");
  refused.value = "";
}
