// Whether the server is there. Once it does not answer it is asked again and again; whoever waits for it
// goes on when it is back.

import { signal } from "@preact/signals";

/** stranger: it was started anew and does not know this browser. */
export const connection = signal<"there" | "lost" | "stranger">("there");
/** How often the server has come back. */
export const returns = signal(0);

const PAUSES = [300, 500, 1000, 1000, 2000, 3000];

async function answers(): Promise<"there" | "lost" | "stranger"> {
  try {
    const { ok, status } = await fetch("/api/status", { cache: "no-store" });
    return ok ? "there" : status === 401 ? "stranger" : "lost";
  } catch {
    return "lost";
  }
}

let coming: Promise<void> | null = null;

async function wait(): Promise<void> {
  for (let tries = 0; ; tries++) {
    connection.value = await answers();
    if (connection.value === "there") break;
    await new Promise((after) => setTimeout(after, PAUSES[Math.min(tries, PAUSES.length - 1)]));
  }
  coming = null;
  returns.value += 1;
}

/** When the server answers again. */
export const awaitServer = (): Promise<void> => (coming ??= wait());
