// The server's addresses: quick calls, jobs, files. A refusal is an error with its sentence.

import { answerLocally, isStatic } from "../engine/local.ts";
import { SERVER } from "../engine/inputs.ts";
import { completeAnswer } from "../views/answer.ts";
import { COLUMNS_TYPE, unpackColumns } from "./columns.ts";
import { awaitServer } from "./connection.ts";
import { host } from "./host.ts";
import { dropMarks, Refusal } from "./refusal.ts";
import { makeId } from "./identity.ts";
import { tab } from "./tab.ts";

export { Refusal };

/** What went wrong, in words. */
export const sentence = (error: unknown): string => dropMarks(error instanceof Error ? error.message : String(error));

/** Whether a call ended because a newer one of its lane came. */
export const superseded = (error: unknown): boolean => error instanceof Refusal && error.kind === "superseded";

const NO_SERVER = `This page has no server. ${SERVER}`;

/** Identity of this loaded page: a copied tab does not go over the calls of its original. */
const load = makeId().slice(0, 8);

async function answered<T>(response: Response): Promise<T> {
  let body: unknown = null;
  try {
    if (response.headers.get("Content-Type") === COLUMNS_TYPE) body = unpackColumns(await response.arrayBuffer());
    else body = JSON.parse((await response.text()) || "null");
  } catch {
    throw new Refusal("The server's answer cannot be read.", "failed", response.status);
  }
  const refused = response.headers.get("X-Refused");
  if (!response.ok || refused) {
    const said = body as { error?: string; kind?: string } | null;
    const status = refused ? Number(refused) : response.status;
    throw new Refusal(said?.error ?? `The server answered ${status}.`, said?.kind ?? "failed", status);
  }
  return body as T;
}

async function asked<T>(path: string, options: RequestInit = {}): Promise<T> {
  if (isStatic()) throw new Refusal(NO_SERVER, "server", 501);
  let response: Response;
  try {
    response = await fetch(path, { ...options, headers: { "X-Tab": tab, "X-Quietly": "1", ...options.headers } });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    void awaitServer();
    throw new Refusal("The server does not answer. Start “martensite app” again.", "lost", 0);
  }
  return answered<T>(response);
}

const running = new Map<string, AbortController>();

/** So many times a call is asked again after the server was gone: what ends it may be the call itself. */
const MOST_TRIES = 3;

/** Whether a call was not answered because the server is not there, or does not know this browser. */
const lost = (error: unknown): boolean => error instanceof Refusal && (error.status === 0 || error.status === 401);

/** A quick call. A newer one of the same lane goes over an older, which then ends as `superseded`. One that the
 * server did not answer is asked again when it is back. */
export async function call<T>(name: string, request: object = {}, lane = ""): Promise<T> {
  if (isStatic()) return answerLocally<T>(name, request);
  if (host) return completeAnswer(name, await host.call(name, request, lane)) as T;
  const control = new AbortController();
  if (lane) {
    running.get(lane)?.abort();
    running.set(lane, control);
  }
  const ask = (): Promise<unknown> =>
    asked<unknown>(`/api/call/${name}`, {
      method: "POST",
      body: JSON.stringify(request),
      headers: { Accept: `${COLUMNS_TYPE}, application/json`, ...(lane ? { "X-Lane": `${load} ${lane}` } : {}) },
      signal: control.signal,
    });
  try {
    for (let tries = 1; ; tries++) {
      try {
        return completeAnswer(name, await ask()) as T;
      } catch (error) {
        if (!lost(error) || tries >= MOST_TRIES) throw error;
        await awaitServer();
      }
    }
  } catch (error) {
    if (error instanceof DOMException) throw new Refusal("A newer request came.", "superseded", 409);
    throw error;
  } finally {
    if (running.get(lane) === control) running.delete(lane);
  }
}

const BUSY = new Refusal("Interrupt the kernel of the notebook to end this run.", "failed", 409);

/** End the call of a lane that the server is at; it then ends with a sentence. */
export const cancelCall = (lane: string): Promise<unknown> =>
  host ? Promise.reject(BUSY) : asked("/api/lane", { method: "DELETE", headers: { "X-Lane": `${load} ${lane}` } });

/** How far the call of a lane is; `done` is null where it is not known. */
export interface CallNote {
  doing: string;
  done: number | null;
}

export const lookAtCall = (lane: string): Promise<CallNote | null> => asked("/api/lane", { headers: { "X-Lane": `${load} ${lane}` } });

export interface JobSummary<Note = Record<string, unknown>> {
  id: string;
  call: string;
  state: "running" | "done" | "failed" | "cancelled";
  began: number;
  ended: number | null;
  last: Note | null;
}

export interface Job<Note = Record<string, unknown>, Outcome = unknown> extends JobSummary<Note> {
  request: Record<string, unknown>;
  trail: Note[];
  outcome: Outcome | string | null;
}

export const beginJob = (name: string, request: object): Promise<JobSummary> =>
  asked("/api/jobs", { method: "POST", body: JSON.stringify({ call: name, request }) });

/** The jobs of a kind that this tab has, the newest first. */
export async function jobs(name: string): Promise<JobSummary[]> {
  return (await asked<JobSummary[]>("/api/jobs")).filter((one) => one.call === name);
}

/** Cancel a job; by force if it has not ended in so many seconds, a few where none are given. */
export const cancelJob = (id: string, within?: number): Promise<JobSummary> =>
  asked(`/api/jobs/${id}${within === undefined ? "" : `?within=${within}`}`, { method: "DELETE" });

/** Code with which the server closes on a job that it does not have. */
const GONE = 4404;

/** Listen to a job until it ends: first all that is known of it, then notes, then its end. */
export function watchJob<Note, Outcome>(
  id: string,
  heard: (message: { job?: Job<Note, Outcome>; note?: Note }) => void,
  lost: (reason: string, gone: boolean) => void,
): () => void {
  const address = `${location.origin.replace("http", "ws")}/api/jobs/${id}/watch?tab=${tab}`;
  const socket = new WebSocket(address);
  let over = false;
  socket.onmessage = (event: MessageEvent<string>) => {
    const message = JSON.parse(event.data) as { job?: Job<Note, Outcome>; note?: Note };
    over ||= message.job !== undefined && message.job.state !== "running";
    heard(message);
  };
  socket.onclose = (event) => {
    if (!over) lost(event.reason || "The connection to the job was lost.", event.code === GONE);
  };
  return () => {
    over = true;
    socket.close();
  };
}

export interface Uploaded {
  key: string;
  name: string;
  bytes: number;
}

/** Whether the server has a file: it forgets all of them when it ends. */
export async function isThere(key: string): Promise<boolean> {
  return fetch(`/api/files/${key}`, { method: "HEAD", headers: { "X-Quietly": "1" } }).then(
    (found) => found.ok && !found.headers.has("X-Refused"),
    () => false,
  );
}

export const upload = (file: File): Promise<Uploaded> =>
  asked(`/api/files?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file });

/** Save something under a name, as a download. */
export function save(name: string, content: Blob | string): void {
  const blob = typeof content === "string" ? new Blob([content], { type: "text/plain" }) : content;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Save a file that the server has made. */
export function take(key: string, name: string): void {
  if (host) return void host.file(key).then((found) => save(name, found));
  const link = document.createElement("a");
  link.href = `/api/files/${key}`;
  link.download = name;
  link.click();
}
