// A project as one file: the session with its files and the reader's notes, as JSON.

import { signal } from "@preact/signals";
import { save } from "../lib/api.ts";
import { forgetSessions, keepFile, listSessions, readFile } from "../lib/store.ts";
import { makeId } from "../lib/identity.ts";
import { tab } from "../lib/tab.ts";
import { keepSignals, readDocument, replaceDocument, type SessionDocument } from "./session.ts";

export const ENDING = ".martensite";
const FORMAT = "martensite project";
const VERSION = 1;
/** Files of up to 64 MiB, in letters, beside the rest. */
const LARGEST = 128 * 2 ** 20;
const DEEPEST = 12;

/** The reader's own words about the session. */
export const notes = signal("");
keepSignals("notes", { notes });

interface Project {
  format: typeof FORMAT;
  version: number;
  title: string;
  saved: string;
  session: SessionDocument;
  /** By key: name, and content in base64. */
  files: Record<string, { name: string; content: string }>;
}

type Named = { name: string; content?: string };

/** Files that a session names, by the key of their content. */
function filesOf(session: SessionDocument): { key: string; name: string }[] {
  const { state } = (session.parts["identify"] ?? {}) as { state?: { file?: Named | null; others?: { file: Named | null }[] } };
  const all = [state?.file, ...(state?.others ?? []).map((one) => one.file)];
  return all.flatMap((file) => (file?.content ? [{ key: file.content, name: file.name }] : []));
}

async function toLetters(content: Blob): Promise<string> {
  const bytes = new Uint8Array(await content.arrayBuffer());
  const parts: string[] = [];
  for (let at = 0; at < bytes.length; at += 2 ** 15) parts.push(String.fromCharCode(...bytes.subarray(at, at + 2 ** 15)));
  return btoa(parts.join(""));
}

const fromLetters = (letters: string): Blob => new Blob([Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0))]);

/** The session as a project. */
export async function makeProject(): Promise<Project> {
  const session = readDocument();
  const files: Project["files"] = {};
  for (const { key, name } of filesOf(session)) {
    const content = await readFile(key);
    if (content) files[key] = { name, content: await toLetters(content) };
  }
  return { format: FORMAT, version: VERSION, title: session.title, saved: new Date().toISOString(), session, files };
}

export async function saveProject(): Promise<void> {
  const project = await makeProject();
  const name = project.title.replace(/[^\w.() -]+/g, "_").slice(0, 60);
  save(`${name}${ENDING}`, new Blob([JSON.stringify(project, null, 1)], { type: "application/json" }));
}

const isTable = (value: unknown): value is Record<string, unknown> => typeof value === "object" && value !== null && !Array.isArray(value);

/** Whether tables stand in tables without end. */
function isDeep(value: unknown, left = DEEPEST): boolean {
  return typeof value === "object" && value !== null && (left === 0 || Object.values(value).some((one) => isDeep(one, left - 1)));
}

/** A project from the text of its file.
 * @throws Error with a sentence: it is none, or of a newer version. */
export function parseProject(name: string, text: string): Project {
  const none = new Error(`“${name}” is no project of martensite.`);
  let found: unknown;
  try {
    found = JSON.parse(text);
  } catch {
    throw text.includes(FORMAT) ? new Error(`“${name}” is cut or damaged: it cannot be read to its end.`) : none;
  }
  if (!isTable(found) || found["format"] !== FORMAT || typeof found["version"] !== "number") throw none;
  if (found["version"] > VERSION) throw new Error(`“${name}” was saved by a newer version of martensite; this one cannot read it.`);
  const { session, files } = found;
  const right = isTable(session) && isTable(session["parts"]) && typeof session["place"] === "string" && isTable(files) && !isDeep(session);
  const bench = right ? (session["parts"] as Record<string, unknown>)["bench"] : null;
  const kept = Object.values(right ? (files as object) : {}) as unknown[];
  const whole = kept.every((one) => isTable(one) && typeof one["name"] === "string" && typeof one["content"] === "string");
  if (!right || !whole || (bench !== undefined && (!isTable(bench) || typeof bench["text"] !== "string")))
    throw new Error(`“${name}” is a project, but a part of it is missing or wrong.`);
  return found as unknown as Project;
}

/** Open a project in place of the session; files in it get new keys, so that nothing else is gone over.
 * @throws Error with a sentence. */
export async function openProject(file: File): Promise<void> {
  if (file.size > LARGEST) throw new Error(`“${file.name}” has ${Math.round(file.size / 2 ** 20)} MiB; a project has at most ${LARGEST / 2 ** 20} MiB.`);
  const project = parseProject(file.name, await file.text());
  let session = JSON.stringify({ ...project.session, version: 1, title: project.title });
  for (const [key, { content }] of Object.entries(project.files)) {
    const fresh = makeId();
    let blob: Blob;
    try {
      blob = fromLetters(content);
    } catch {
      throw new Error(`“${file.name}” is a project, but a file in it is damaged.`);
    }
    await keepFile(fresh, blob);
    if (key) session = session.replaceAll(JSON.stringify(key), JSON.stringify(fresh));
  }
  const document = JSON.parse(session) as SessionDocument;
  const place = /^#\/[a-z]+/.test(document.place) ? document.place : "#/bench";
  await replaceDocument({ ...document, place });
}

/** Sessions other than this one, the newest first. */
export async function listEarlier(): Promise<{ title: string; at: number; document: SessionDocument }[]> {
  return (await listSessions()).filter((one) => one.id !== tab).slice(0, 8);
}

/** Forget all sessions but this one; other open tabs keep their own when they go on. */
export const forgetEarlier = (): Promise<void> => forgetSessions(tab);

/** Begin without anything; what is here stays among the earlier sessions. */
export const beginAnew = (): Promise<void> => replaceDocument({ version: 1, place: "#/bench", title: "Session", parts: {} });
