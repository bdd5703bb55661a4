// A row of the form: label, mark of what is changed, button for what is known of it, and the control.

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { whyFixed } from "../engine/fixed.ts";
import { tellBesideField } from "../lib/refusal.ts";
import { capital } from "../lib/words.ts";
import { Details, hint } from "./details.tsx";
import { isOnTop, putOnTop } from "./pinned.ts";
import { refusals } from "./state.ts";
import { Symbol } from "../ui/symbol.tsx";
import type { SingleNode } from "./types.ts";

export const idOf = (path: string): string => `form-${path.replaceAll(/[^\w-]/g, "-")}`;
const faultId = (path: string): string => `${idOf(path)}-fault`;

/** Attributes of a control that say whether its value was refused, and why. */
export function faulty(path: string): { "aria-invalid"?: "true"; "aria-describedby"?: string } {
  return refusals.value[path] ? { "aria-invalid": "true", "aria-describedby": faultId(path) } : {};
}

export function nameOf(node: SingleNode): ComponentChildren {
  return node.symbol ? <Symbol text={node.symbol} /> : capital(node.title);
}

/** Keep a control on top, or take it away from there. */
function Pin({ path, title }: { path: string; title: string }) {
  const on = isOnTop(path);
  const label = on ? `Take ${title} off the top` : `Keep ${title} on top`;
  return (
    <button type="button" class="quiet info pin" aria-pressed={on} aria-label={label} title={label} onClick={() => putOnTop(path, !on)}>
      <svg viewBox="0 0 16 16" width="13" height="13" aria-hidden="true">
        <path d="M5 1.5h6l-1 5 2.5 3h-9l2.5-3zM8 9.5v5" fill={on ? "currentColor" : "none"} stroke="currentColor" stroke-width="1.4" stroke-linejoin="round" />
      </svg>
    </button>
  );
}

/** Controls that are seen but not changed, and why. */
export function Fixed({ words, children }: { words: string; children: ComponentChildren }) {
  return (
    <fieldset class="fixed" disabled title={words}>
      {children}
    </fieldset>
  );
}

export function Row({ node, children }: { node: SingleNode; children: ComponentChildren }) {
  const open = useSignal(false);
  const id = idOf(node.path);
  const words = refusals.value[node.path];
  const fixed = whyFixed(node.path);
  const about = node.symbol ? node.meaning : "";
  return (
    <div class={`form-row ${node.changed ? "changed" : ""}`}>
      <div class="form-label">
        <label for={id} title={hint(node)}>
          {nameOf(node)} {about && <span class="small about">{about}</span>}
        </label>
        {node.changed && (
          <span class="mark" title="Changed from its default">
            <span aria-hidden="true">●</span>
            <span class="hidden">changed</span>
          </span>
        )}
        {node.origin.doubtful && (
          <span class="mark doubtful" title={`${capital(node.origin.kind ?? "")}, not measured`}>
            {node.origin.kind}
          </span>
        )}
        {(node.sort === "number" || isOnTop(node.path)) && <Pin path={node.path} title={node.title} />}
        <button
          type="button"
          class="quiet info"
          aria-expanded={open.value}
          aria-controls={`${id}-more`}
          aria-label={`About ${node.title}`}
          title={hint(node)}
          onClick={() => (open.value = !open.value)}
        >
          <span aria-hidden="true">i</span>
        </button>
      </div>
      {fixed ? <Fixed words={fixed}>{children}</Fixed> : children}
      {words && (
        <p class="fault small" id={faultId(node.path)} role="alert">
          {tellBesideField(words, node.sort === "number" ? node.label : "")}
        </p>
      )}
      {open.value && <Details node={node} id={`${id}-more`} />}
    </div>
  );
}
