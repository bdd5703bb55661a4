// Controls that a page without a server cannot change by itself.

import { signal } from "@preact/signals";
import { SERVER } from "./inputs.ts";

/** Paths of the controls that it can change; null where there is a server. */
export const movable = signal<ReadonlySet<string> | null>(null);

/** Why a control cannot be changed here; empty if it can. */
export const whyFixed = (path: string): string =>
  movable.value === null || movable.value.has(path) ? "" : `This control needs the server. ${SERVER}`;
