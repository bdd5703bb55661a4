// The session of this tab as a document: every page says what of it is worth keeping, and gets it back
// after a reload, in a copied tab, in a new one, or from a project file.
//
// It is kept in IndexedDB a moment after every change, and once more, at once, when the page goes.

import { effect, type Signal } from "@preact/signals";
import { forgetSessions, keepSession, listSessions, readSession, type Stored } from "../lib/store.ts";
import { makeId } from "../lib/identity.ts";
import { claimTab, isNew, tab } from "../lib/tab.ts";

export interface SessionDocument {
  version: 1;
  /** Address behind the `#`. */
  place: string;
  title: string;
  /** What each part keeps, by its name. */
  parts: Record<string, unknown>;
}

interface Part {
  read: () => unknown;
  write: (kept: unknown) => void;
}

/** What the page keeps at once when it goes. */
const LEAVING = "martensite-session";
/** From a change to its being kept, and the longest wait while changes go on [ms]. */
const [SOON, LATEST] = [200, 1000];

const parts = new Map<string, Part>();
/** What is kept of parts that are not loaded. */
let resting: Record<string, unknown> = {};
/** Whether the session was opened: nothing is kept before, nor in a report. */
let opened = false;
/** Whether another document is about to take the place of this one. */
let closed = false;

/** The session before this tab's, where a link took its place. */
export let earlier: SessionDocument | null = null;

function hand(part: Part, name: string): void {
  if (!(name in resting)) return;
  const kept = resting[name];
  delete resting[name];
  try {
    part.write(kept);
  } catch {
    // another version wrote it: this part begins anew
  }
}

/** Keep a part of the session: `write` gets what `read` gave before, at once or when the session is opened. */
export function keepPart(name: string, read: () => unknown, write: (kept: unknown) => void): void {
  const part = { read, write };
  parts.set(name, part);
  hand(part, name);
  effect(() => (read(), touch()));
}

/** Keep signals; what is kept of another sort than what stands there is passed over. */
export function keepSignals(name: string, signals: Record<string, Signal>): void {
  const sort = (value: unknown): string => (Array.isArray(value) ? "list" : typeof value);
  const read = (): unknown => Object.fromEntries(Object.entries(signals).map(([key, one]) => [key, one.value as unknown]));
  keepPart(name, read, (kept) => {
    for (const [key, value] of Object.entries(kept as Record<string, unknown>)) {
      const one = signals[key];
      const now: unknown = one?.peek();
      if (one && (now === null || value === null || sort(value) === sort(now))) one.value = value;
    }
  });
}

/** What a part keeps now. */
export const readPart = (name: string): unknown => parts.get(name)?.read() ?? resting[name];

/** Give a part something to take up, now or when it is loaded. */
export function writePart(name: string, kept: unknown): void {
  if (kept === undefined) return;
  resting[name] = kept;
  const part = parts.get(name);
  if (part) hand(part, name);
}

/** The title in a scenario. */
export const TITLE = /^title\s*=\s*"((?:[^"\\]|\\.)*)"/m;

/** What a session is called: the title of the scenario on its bench. */
function titled(kept: Record<string, unknown>): string {
  const { text } = (kept["bench"] ?? {}) as { text?: unknown };
  return (typeof text === "string" && TITLE.exec(text)?.[1]) || "Session";
}

/** The whole session as it is now. */
export function readDocument(): SessionDocument {
  const now: Record<string, unknown> = { ...resting };
  for (const [name, part] of parts) now[name] = part.read();
  return { version: 1, place: location.hash, title: titled(now), parts: now };
}

const stored = (): Stored => {
  const document = readDocument();
  return { id: tab, at: Date.now(), title: document.title, document };
};

// ---------------------------------------------------------------- keeping

let timer = 0;
let waitingSince = 0;

/** Something has changed that is to be kept. */
export function touch(): void {
  if (!opened || closed) return;
  const now = performance.now();
  waitingSince ||= now;
  clearTimeout(timer);
  timer = window.setTimeout(() => void save(), Math.min(SOON, Math.max(0, waitingSince + LATEST - now)));
}

async function save(): Promise<void> {
  waitingSince = 0;
  if (!opened || closed) return;
  try {
    await keepSession(stored());
  } catch {
    // the disk is full or keeping is not allowed: the tab alone remembers
  }
}

/** Keep at once what would come too late when the page goes. */
function leave(): void {
  if (!opened || closed) return;
  const now = stored();
  void keepSession(now).catch(() => undefined);
  try {
    sessionStorage.setItem(LEAVING, JSON.stringify(now));
  } catch {
    sessionStorage.removeItem(LEAVING);
  }
}

/** What this tab, or the one it was copied from, kept when its page went. */
function left(id: string): Stored | null {
  try {
    const found = JSON.parse(sessionStorage.getItem(LEAVING) ?? "null") as Stored | null;
    return found?.id === id ? found : null;
  } catch {
    return null;
  }
}

// ---------------------------------------------------------------- opening

/** Parts that a link brings with it. */
export const LINKED = ["runs", "view"];

/** Long work of another tab is its own. */
function withoutRunning(document: SessionDocument): SessionDocument {
  const jobs = Object.entries((document.parts["jobs"] ?? {}) as Record<string, { state?: string }>);
  return { ...document, parts: { ...document.parts, jobs: Object.fromEntries(jobs.filter(([, job]) => job.state !== "running")) } };
}

async function find(copied: string): Promise<SessionDocument | null> {
  const id = copied || tab;
  const own = [left(id), isNew ? undefined : await readSession(id)].filter((one) => !!one).sort((a, b) => b.at - a.at)[0];
  if (own) return copied ? withoutRunning(own.document) : own.document;
  const last = isNew ? (await listSessions())[0] : undefined;
  return last ? withoutRunning(last.document) : null;
}

/** Take up the session of this tab; a new one begins with the last one, on whatever page it was. */
export async function openSession(): Promise<void> {
  const copied = await claimTab();
  let found: SessionDocument | null = null;
  try {
    found = await find(copied);
  } catch {
    // nothing can be read: the session begins anew
  }
  if (found?.version === 1) {
    resting = { ...found.parts };
    if (isNew && location.hash.includes("scenario=")) {
      earlier = found; // the link's scenario stands by itself
      for (const name of ["bench", "wished", ...LINKED]) delete resting[name];
    }
    if (!location.hash && found.place) {
      history.replaceState(null, "", found.place);
      dispatchEvent(new HashChangeEvent("hashchange"));
    }
  }
  opened = true;
  for (const [name, part] of parts) hand(part, name);
  addEventListener("pagehide", leave);
  document.addEventListener("visibilitychange", () => document.hidden && void save());
  addEventListener("hashchange", touch);
  touch();
  Object.assign(globalThis, { martensiteSession: readDocument }); // to look at, and for tests
  setTimeout(() => void forgetSessions().catch(() => undefined), 5000);
}

/** Put another document in the place of this one, which stays among the earlier sessions; the page loads anew. */
export async function replaceDocument(next: SessionDocument): Promise<void> {
  const before = stored();
  await keepSession({ ...before, id: makeId() });
  closed = true;
  const now: Stored = { id: tab, at: Date.now(), title: next.title, document: next };
  await keepSession(now);
  try {
    sessionStorage.setItem(LEAVING, JSON.stringify(now));
  } catch {
    sessionStorage.removeItem(LEAVING);
  }
  history.replaceState(null, "", next.place || "#/bench");
  location.reload();
}
