// What the browser keeps on this machine: sessions by tab, and files by key, in IndexedDB; sessions in
// localStorage where there is none.

import type { SessionDocument } from "../state/session.ts";

export interface Stored {
  id: string;
  /** When it was kept [ms]. */
  at: number;
  title: string;
  document: SessionDocument;
}

const NAME = "martensite";
const [SESSIONS, FILES] = ["sessions", "files"];
const PREFIX = "martensite-session-";
/** From then on a database that does not open is none [ms]. */
const PATIENCE = 2000;
/** Sessions that are kept beside those of open tabs. */
const MOST = 20;

function asked<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((done, failed) => {
    request.onsuccess = () => done(request.result);
    request.onerror = () => failed(request.error ?? new Error("The browser does not store data."));
  });
}

let opening: Promise<IDBDatabase | null> | null = null;

/** The database; null where there is none, as in some private windows. */
function database(): Promise<IDBDatabase | null> {
  return (opening ??= (async () => {
    try {
      const request = indexedDB.open(NAME, 1);
      request.onupgradeneeded = () => {
        request.result.createObjectStore(SESSIONS, { keyPath: "id" }).createIndex("at", "at");
        request.result.createObjectStore(FILES);
      };
      const none = new Promise<null>((tell) => setTimeout(() => tell(null), PATIENCE));
      return await Promise.race([asked(request), none]);
    } catch {
      return null;
    }
  })());
}

async function through<T>(name: string, mode: IDBTransactionMode, work: (store: IDBObjectStore) => IDBRequest<T>): Promise<T | undefined> {
  const found = await database();
  return found ? asked(work(found.transaction(name, mode).objectStore(name))) : undefined;
}

function local(): Stored[] {
  const found = Object.keys(localStorage).filter((key) => key.startsWith(PREFIX));
  return found.map((key) => JSON.parse(localStorage.getItem(key) ?? "null") as Stored).filter(Boolean);
}

/** All sessions, the newest first. */
export async function listSessions(): Promise<Stored[]> {
  const found = (await database()) ? ((await through<Stored[]>(SESSIONS, "readonly", (store) => store.getAll())) ?? []) : local();
  return found.sort((a, b) => b.at - a.at);
}

export async function readSession(id: string): Promise<Stored | undefined> {
  if (await database()) return through<Stored>(SESSIONS, "readonly", (store) => store.get(id));
  return local().find((one) => one.id === id);
}

export async function keepSession(session: Stored): Promise<void> {
  if (await database()) await through(SESSIONS, "readwrite", (store) => store.put(session));
  else localStorage.setItem(PREFIX + session.id, JSON.stringify(session));
}

export async function keepFile(key: string, file: Blob): Promise<void> {
  await through(FILES, "readwrite", (store) => store.put(file, key));
}

export const readFile = (key: string): Promise<Blob | undefined> => through<Blob>(FILES, "readonly", (store) => store.get(key));

/** Forget sessions, and files that none of the others names: the oldest, or all but one. */
export async function forgetSessions(only = ""): Promise<void> {
  const sessions = await listSessions();
  const left = only ? sessions.filter((one) => one.id === only) : sessions.slice(0, MOST);
  const over = sessions.filter((one) => !left.includes(one));
  for (const { id } of over) {
    if (await database()) await through(SESSIONS, "readwrite", (store) => store.delete(id));
    else localStorage.removeItem(PREFIX + id);
  }
  if (!over.length) return;
  const named = JSON.stringify(left);
  const keys = (await through(FILES, "readonly", (store) => store.getAllKeys())) ?? [];
  for (const key of keys) if (!named.includes(String(key))) await through(FILES, "readwrite", (store) => store.delete(key));
}
