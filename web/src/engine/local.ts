// The calls of the bench that a page answers by itself: a static page has no server.

import { Refusal } from "../lib/refusal.ts";
import type { Run } from "../lib/types.ts";
import { compareDocuments, fillForm, findKnown, readChanges, writeChanged } from "./documents.ts";
import { fetchFile } from "./files.ts";
import { movable } from "./fixed.ts";
import { predictInputs, SERVER, type Changes } from "./inputs.ts";
import type { Manifest, RunCore, Scenario } from "./types.ts";
import { drawRun } from "./drawn.ts";
import type { Answered, Asked, Expected, Source } from "./worker.ts";

/** Address of the manifest, if this page has no server. */
const manifestAddress = (): string | null =>
  document.querySelector<HTMLMetaElement>('meta[name="martensite-runs"]')?.content ?? null;

export const isStatic = (): boolean => typeof document !== "undefined" && manifestAddress() !== null;

const files = new Map<string, Promise<unknown>>();

function fetchJson<T>(address: string): Promise<T> {
  const known = files.get(address) ?? fetchFile(address).then((response) => response.json());
  files.set(address, known);
  known.catch(() => files.delete(address));
  return known as Promise<T>;
}

const readManifest = (): Promise<Manifest> => fetchJson(new URL(manifestAddress() ?? "", document.baseURI).href);
/** Address of a file beside the manifest. */
const locateFile = (file: string): string => new URL(file, new URL(manifestAddress() ?? "", document.baseURI)).href;

async function readScenario(manifest: Manifest, name: string): Promise<Scenario> {
  const listed = manifest.scenarios.find((one) => one.name === name);
  if (!listed) throw new Refusal(`This page has no scenario \`${name}\`. ${SERVER}`, "server", 501);
  return fetchJson<Scenario>(locateFile(listed.file));
}

/** Fetch what the first scenario needs while the page itself is coming. */
export async function expectFirst(): Promise<void> {
  worker ??= startWorker();
  const manifest = await readManifest();
  const first = manifest.scenarios[0];
  if (!first) return;
  worker.postMessage({ fetch: locateFile(first.module) } satisfies Expected);
  await readScenario(manifest, first.name);
}

interface Meant {
  scenario: Scenario;
  text: string;
  changes: Changes;
}

/** What a document with changes means. */
async function understand(text: string, changes: Record<string, unknown>): Promise<Meant> {
  const manifest = await readManifest();
  const next = writeChanged(text, changes);
  const known = findKnown(manifest, next);
  const scenario = await readScenario(manifest, known.name);
  return { scenario, text: next, changes: readChanges(scenario, known.written) };
}

// ---------------------------------------------------------------- runs

let worker: Worker | null = null;
const told = new Set<string>();
let count = 0;
let running: { id: number; done: (found: Answered) => void } | null = null;
let waiting: { begin: () => void; drop: () => void } | null = null;

/** A run beside the page; a newer request goes over one that has not begun. */
export function runLocally(scenario: Scenario, changes: Changes, text: string, from: Source = locateFile(scenario.module)): Promise<RunCore> {
  return new Promise((resolve, reject) => {
    const begin = (): void => {
      const id = ++count;
      running = {
        id,
        done: (found) => ("run" in found ? resolve(found.run) : reject(new Refusal(found.refused, found.kind, 400))),
      };
      const asked: Asked = {
        id,
        from,
        scenario: told.has(scenario.name) ? null : scenario,
        name: scenario.name,
        changes,
        text,
      };
      told.add(scenario.name);
      (worker ??= startWorker()).postMessage(asked);
    };
    waiting?.drop();
    waiting = null;
    if (!running) begin();
    else waiting = { begin, drop: () => reject(new Refusal("A newer request came.", "superseded", 409)) };
  });
}

function startWorker(): Worker {
  const made = new Worker(new URL("engine.js", document.baseURI), { type: "module" });
  const settle = (found: Answered): void => {
    const { done } = running!;
    running = null;
    const next = waiting;
    waiting = null;
    next?.begin();
    done(found);
  };
  made.onmessage = (event: MessageEvent<Answered>) => settle(event.data);
  made.onerror = () => {
    worker = null;
    told.clear();
    if (running) settle({ id: running.id, refused: "The calculation ended unexpectedly; try again.", kind: "failed" });
  };
  return made;
}

// ---------------------------------------------------------------- by hand

/** A scenario, its changes, and where its module lies: what a model needs that is stepped by hand. */
export interface Stepped {
  scenario: Scenario;
  changes: Changes;
  address: string;
}

export async function findStepped(text: string): Promise<Stepped> {
  const { scenario, changes } = await understand(text, {});
  return { scenario, changes, address: locateFile(scenario.module) };
}

// ---------------------------------------------------------------- calls

type Request = Record<string, unknown>;

const calls: Record<string, (request: Request) => Promise<unknown>> = {
  scenarios: async () => ({ scenarios: (await readManifest()).scenarios }),
  form: async (request) => {
    if (!request["text"] || (request["removed"] as string[] | undefined)?.length) throw new Refusal(`This page cannot do that by itself. ${SERVER}`, "server", 501);
    const { scenario, text, changes } = await understand(request["text"] as string, (request["changes"] as Request | undefined) ?? {});
    movable.value = new Set([...scenario.controls.map((one) => one.path), ...Object.keys(scenario.rows)]);
    return fillForm(scenario, text, changes, predictInputs(scenario, changes));
  },
  run: async (request): Promise<Run> => {
    const { scenario, text, changes } = await understand(request["text"] as string, (request["changes"] as Request | undefined) ?? {});
    const core = await runLocally(scenario, changes, text);
    return { ...drawRun(scenario, core), cautions: core.cautions };
  },
  studies: async () => fetchJson(locateFile("studies.json")),
  study_page: async (request) => fetchJson(locateFile(`study-${encodeURIComponent(request["name"] as string)}.json`)),
  study_figure: async (request) => ({ svg: await (await fetchFile(new URL(`studies/${encodeURIComponent(request["name"] as string)}.svg`, document.baseURI).href)).text() }),
  differences: async (request) => compareDocuments(request["texts"] as string[]),
};

/** The answer to a call, as the server would give it. */
export async function answerLocally<T>(name: string, request: object): Promise<T> {
  const own = calls[name];
  if (!own) throw new Refusal(`This page has no server, which this function needs. ${SERVER}`, "server", 501);
  return (await own(request as Request)) as T;
}
