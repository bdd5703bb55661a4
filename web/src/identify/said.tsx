// Sentences of the library: names in backquotes as code, units as people write them.

import { dropOptions } from "../lib/refusal.ts";

export function Said({ children }: { children: string }) {
  return <>{dropOptions(children).split("`").map((part, k) => (k % 2 ? <code key={k}>{part}</code> : part.replace(/(?<= )degC\b/g, "°C")))}</>;
}
