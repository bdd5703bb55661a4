// Where in the page we are: `#/studies/finger`, `#/bench?scenario=…`.

import { signal } from "@preact/signals";
import { isStatic } from "../engine/local.ts";
import { host } from "../lib/host.ts";

export interface Place {
  page: string;
  rest: string[];
  query: URLSearchParams;
}

/** What the address says now, which `place` may not have heard of yet. */
export function readPlace(): Place {
  const [path = "", query = ""] = location.hash.replace(/^#\/?/, "").split("?");
  const [page = "", ...rest] = path.split("/").map(decodeURIComponent);
  const asked = new URLSearchParams(query);
  return { page: page || (asked.has("scenario") ? "bench" : "start"), rest, query: asked };
}

export const place = signal<Place>(readPlace());
addEventListener("hashchange", () => (place.value = readPlace()));

/** Pages that work without a server. */
const ALONE = ["start", "bench", "studies"];

/** Whether a page works here. */
export const isOffered = (page: string): boolean => !isStatic() || ALONE.includes(page);

/** In a notebook there is one page. */
export const go = (path: string): void => void (host || (location.hash = `#/${path}`));

/**
 * Change what stands behind the question mark without a new entry in the history.
 *
 * Nothing is changed if the address names another page already, which `place` may not have heard of yet.
 */
export function remember(page: string, query: Record<string, string>): void {
  if (readPlace().page !== page) return;
  const text = new URLSearchParams(query).toString();
  history.replaceState(null, "", `#/${page}${text ? `?${text}` : ""}`);
}
