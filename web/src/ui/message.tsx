// A sentence that the reader should see: an error, a caution, a note.

import type { ComponentChildren } from "preact";

export function Message({ kind, children }: { kind: "error" | "caution" | "note"; children: ComponentChildren }) {
  return (
    <p class={`message ${kind}`} role={kind === "error" ? "alert" : "status"}>
      {children}
    </p>
  );
}
