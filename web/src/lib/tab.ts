// Identity of this tab. It outlives a reload, so that its jobs and its session are found again; a tab
// that the browser has copied from another gets one of its own.

import { makeId } from "./identity.ts";

const PLACE = "martensite-tab";
/** A page that is being reloaded holds its lock for a moment [ms]. */
const PATIENCE = 1000;

/** Where pages may keep nothing, as in a report that is opened from a mail. */
function read(): string {
  try {
    return sessionStorage.getItem(PLACE) ?? "";
  } catch {
    return "";
  }
}

function rename(): string {
  tab = makeId();
  try {
    sessionStorage.setItem(PLACE, tab);
  } catch {
    // a reload begins a new tab
  }
  return tab;
}

const before = read();
/** Whether the tab was opened anew. */
export const isNew = before === "";
export let tab: string = before || rename();

/** Hold a lock for as long as the page lives; whether it could be had. */
function holdLock(name: string): Promise<boolean> {
  if (!("locks" in navigator)) return Promise.resolve(true);
  return new Promise((tell) => {
    const control = new AbortController();
    const timer = setTimeout(() => control.abort(), PATIENCE);
    const held = (): Promise<void> => (clearTimeout(timer), tell(true), new Promise<void>(() => undefined));
    navigator.locks.request(name, { signal: control.signal }, held).catch(() => tell(false));
  });
}

/** Make sure that no other page has this identity; the one that it was copied from, if any. */
export async function claimTab(): Promise<string> {
  const known = tab;
  if (await holdLock(`martensite ${known}`)) return "";
  void holdLock(`martensite ${rename()}`);
  return known;
}
