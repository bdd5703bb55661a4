// The form of a sizing, kept in the address, and the work it begins.

import { computed, signal } from "@preact/signals";
import { call, sentence, superseded } from "../lib/api.ts";
import { readComma } from "../lib/numbers.ts";
import { watched } from "../state/jobs.ts";
import { place, remember } from "../state/route.ts";
import { keepSignals } from "../state/session.ts";
import type { Candidate, Cell, Checked, Fields, Form, Mapped, MapNote, Note, Sizing } from "./types.ts";

export type Tab = "wires" | "catalogue";

export const sizing = watched<Note, Sizing>("size");
export const check = watched<Note, Checked>("size_catalogue");
export const mapping = watched<MapNote, Mapped>("size_map");
export const fields = signal<Fields>({});
export const tab = signal<Tab>("wires");
export const form = signal<Form | null>(null);
keepSignals("size", { fields, tab });
/** Sentence of a form that could not be had. */
export const trouble = signal("");

/** The answer of the newest sizing. */
export const answer = computed<Sizing | null>(() => {
  const job = sizing.job.value;
  return job?.state === "done" && job.outcome && typeof job.outcome === "object" ? job.outcome : null;
});

const written = (now: Fields): Fields => Object.fromEntries(Object.entries(now).filter(([, text]) => text.trim()).map(([name, text]) => [name, readComma(text)]));

/** Whether the answer is for another form than the one that is shown. */
export const outdated = computed(() => {
  const asked = answer.value?.asked;
  if (!asked) return false;
  const now = written(fields.value);
  const names = new Set([...Object.keys(asked), ...Object.keys(now)]);
  return [...names].some((name) => (asked[name] ?? "").trim() !== (now[name] ?? "").trim());
});

function keep(): void {
  const query = { ...written(fields.value), ...(tab.value === "catalogue" ? { tab: "catalogue" } : {}) };
  remember("size", query);
}

/** In the address: whether a form that is still empty is filled with the example. */
const EXAMPLE = "example";
let exemplary = false;

/** Take the form from the address; an address without one leaves the form as it is. */
export function fromAddress(): void {
  const found: Fields = {};
  for (const [name, text] of place.value.query) if (name !== "tab" && name !== EXAMPLE) found[name] = text;
  exemplary ||= place.value.query.has(EXAMPLE);
  if (place.value.query.has("tab")) tab.value = "catalogue";
  if (Object.keys(found).length > 0) fields.value = found;
  keep();
}

export function show(next: Tab): void {
  tab.value = next;
  keep();
}

let waiting = 0;

export function fill(next: Fields): void {
  fields.value = next;
  keep();
  clearTimeout(waiting);
  waiting = window.setTimeout(() => void ask(), 250);
}

/** Change a field; what was said about its old text no longer holds. */
export function put(name: string, text: string): void {
  if (form.value?.refused[name]) {
    const { [name]: _, ...refused } = form.value.refused;
    form.value = { ...form.value, refused };
  }
  fill({ ...fields.value, [name]: text });
}

/** Have the form read by the server; nothing is simulated. */
export async function ask(): Promise<void> {
  try {
    const found = await call<Form>("size_form", { fields: written(fields.value) }, "size form");
    form.value = found;
    trouble.value = "";
    if (exemplary && Object.keys(written(fields.value)).length === 0) fill({ ...found.example });
    exemplary = false;
    if (found.unknown.length === 0) return;
    trouble.value = `The address contains unknown fields: ${found.unknown.join(", ")}.`;
    fields.value = Object.fromEntries(Object.entries(fields.value).filter(([name]) => !found.unknown.includes(name)));
    keep();
  } catch (error) {
    if (!superseded(error)) trouble.value = sentence(error);
  }
}

export const begin = (): Promise<void> => sizing.begin({ fields: written(fields.value) });
export const beginMap = (): Promise<void> => mapping.begin({ fields: written(fields.value) });

/** Cells of the newest map so far, and its axes; null before the first. */
export const mapped = computed<{ forces: number[]; strokes: number[]; cells: Cell[] } | null>(() => {
  const job = mapping.job.value;
  const first = job?.trail[0] ?? job?.last;
  if (!job || !first) return null;
  const cells = job.trail.flatMap((note) => (note.cell ? [note.cell] : []));
  return { forces: first.forces, strokes: first.strokes, cells };
});

/** Wish for another force [N] and stroke [m], as of a point on the map, and look for its wires. */
export async function wish(force: number, stroke: number): Promise<void> {
  fill({ ...fields.value, force: `${Number(force.toPrecision(3))} N`, stroke: `${Number((1e3 * stroke).toPrecision(3))} mm` });
  await begin();
}

export const beginCheck = (): Promise<void> => check.begin({ fields: written(fields.value) });

export const fileName = (found: Candidate): string => `flexinol-${found.size.replace(" mm", "mm")}-${found.alloy}.toml`;
