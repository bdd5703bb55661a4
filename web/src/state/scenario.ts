// The scenario on the bench: its text is the whole state. Every change is one step to undo.

import { batch, computed, effect, signal } from "@preact/signals";
import { packLink, unpackLink } from "../lib/pack.ts";
import { go, place, readPlace, remember } from "./route.ts";
import { earlier, keepPart, LINKED, readPart, TITLE, touch, writePart } from "./session.ts";

const MOST_STEPS = 200;
/** Letters of all steps together. */
const MOST_LETTERS = 2 ** 20;

/** The newest steps, as many as are kept. */
function newest(steps: string[]): string[] {
  let [first, letters] = [steps.length, 0];
  while (first > 0 && steps.length - first < MOST_STEPS && (letters += steps[first - 1]?.length ?? 0) < MOST_LETTERS) first--;
  return steps.slice(first);
}

/** The document, TOML. Empty until one is loaded. */
export const text = signal("");
const before = signal<string[]>([]);
const after = signal<string[]>([]);

export const canUndo = computed(() => before.value.length > 0);
export const canRedo = computed(() => after.value.length > 0);

/** Put another document in place; `merge` takes it as part of the last change, as of a slider. */
export function change(next: string, merge = false): void {
  if (next === text.value) return;
  batch(() => {
    if (!merge && text.value) before.value = newest([...before.value, text.value]);
    after.value = [];
    text.value = next;
  });
}

export function undo(): void {
  const last = before.value.at(-1);
  if (last === undefined) return;
  batch(() => {
    after.value = [...after.value, text.value];
    before.value = before.value.slice(0, -1);
    text.value = last;
  });
}

export function redo(): void {
  const next = after.value.at(-1);
  if (next === undefined) return;
  batch(() => {
    before.value = [...before.value, text.value];
    after.value = after.value.slice(0, -1);
    text.value = next;
  });
}

// ---------------------------------------------------------------- kept in the session

/** The letters in the address that stand for what is on the bench. */
let letters = "";

interface Kept {
  text: string;
  before: string[];
  after: string[];
  letters: string;
}

const isTexts = (value: unknown): value is string[] => Array.isArray(value) && value.every((one) => typeof one === "string");

keepPart(
  "bench",
  (): Kept => ({ text: text.value, before: before.value, after: after.value, letters }),
  (kept) => {
    const found = kept as Kept;
    if (typeof found.text !== "string" || !isTexts(found.before) || !isTexts(found.after)) return;
    letters = found.letters;
    batch(() => {
      before.value = found.before;
      after.value = found.after;
      text.value = found.text;
    });
  },
);

// ---------------------------------------------------------------- links

/** Why the scenario of the address cannot be read; empty if it can. */
export const broken = signal("");
const BROKEN = "This link is damaged: characters are missing or were changed, so its scenario cannot be read. Copy the whole link again.";

/** The link to what is on the bench: scenario, pinned runs, cursor, view. */
export function makeLink(): Promise<string> {
  return packLink({ text: text.value, parts: Object.fromEntries(LINKED.map((name) => [name, shortened(readPart(name))])) });
}

/** Return the address of this bench with the scenario, without the token of a server. */
export async function makeAddress(): Promise<string> {
  return `${location.href.replace(/[?#].*/, "")}#/bench?scenario=${await makeLink()}`;
}

/** Without what is empty. */
function shortened(part: unknown): unknown {
  const entries = Object.entries((part ?? {}) as Record<string, unknown>);
  return Object.fromEntries(entries.filter(([, value]) => value !== null && value !== 0 && JSON.stringify(value)?.length > 2));
}

/** Take up the link of the address, if one is there that is not on the bench already. */
export async function fromAddress(): Promise<boolean> {
  broken.value = "";
  const found = place.value.query.get("scenario");
  if (!found) return false;
  if (found === letters && text.value) return true;
  try {
    const link = await unpackLink(found);
    batch(() => {
      change(link.text);
      for (const name of LINKED) writePart(name, link.parts[name]);
    });
    letters = found;
    return true;
  } catch {
    broken.value = BROKEN;
    return true;
  }
}

/** What was on the bench before a link that cannot be read: its title, and a way back to it. */
export function findLast(): { title: string; open: () => void } | null {
  const parts = earlier?.parts ?? {};
  const last = text.value ? { text: text.value } : (parts["bench"] as Kept | undefined);
  if (!last?.text) return null;
  const open = (): void => {
    if (!text.value) for (const name of ["bench", ...LINKED]) writePart(name, parts[name]);
    broken.value = "";
  };
  return { title: TITLE.exec(last.text)?.[1] ?? "scenario without a title", open };
}

let waiting = 0;

/** Keep the address in step with the bench. */
export function followInAddress(): () => void {
  return effect(() => {
    const now = text.value;
    for (const name of LINKED) readPart(name); // any change of them
    if (!now || broken.value || place.value.page !== "bench") return;
    clearTimeout(waiting);
    waiting = window.setTimeout(async () => {
      const made = await makeLink();
      if (text.value !== now || broken.value) return;
      const there = readPlace().query.get("scenario");
      if (there && there !== letters) return; // a link that came just now is not written over before it is read
      letters = made;
      remember("bench", { scenario: made });
      touch();
    }, 300);
  });
}

/** Put a scenario on the bench and go there. */
export function openInBench(document: string): void {
  change(document);
  go("bench");
}
