// What is known of an entry: meaning, range, default, where it comes from; and the ways back.

import type { ComponentChildren } from "preact";
import { isOwn } from "./patch.ts";
import { restructure } from "./state.ts";
import type { MaterialValue, Origin, SingleNode } from "./types.ts";

const sourced = (origin: Origin): string =>
  [origin.words, origin.source, origin.where, origin.note].filter(Boolean).join("; ");

/** The same in lines, for who points at it. */
export function hint(node: SingleNode): string {
  const lines = [node.meaning];
  if (node.sort === "number") {
    lines.push(`Allowed: ${node.allowed}`);
    if (node.usual !== null) lines.push(`Default: ${node.usual}`);
  }
  lines.push(`From: ${sourced(node.origin)}`);
  return lines.join("\n");
}

function Line({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

function Source({ origin }: { origin: Origin }) {
  return (
    <>
      {origin.doubtful && <strong>Not measured: </strong>}
      {origin.words}
      {origin.source && <div>{[origin.source, origin.where].filter(Boolean).join(", ")}</div>}
      {origin.note && <div>{origin.note}</div>}
    </>
  );
}

/** The value that holds if the scenario has none. */
function fallback(node: SingleNode): { words: string; given: MaterialValue | null } | null {
  if (!isOwn(node)) return null;
  if (node.sort === "number" && node.material) return { words: `Use the material's ${node.material.text}`, given: node.material };
  if (node.required || node.sort === "material") return null;
  if (node.sort === "number") return { words: `Use the default, ${node.usual ?? "no limit"}`, given: null };
  return { words: "Use the default", given: null };
}

export function Details({ node, id }: { node: SingleNode; id: string }) {
  const back = fallback(node);
  return (
    <div class="details small" id={id}>
      <dl>
        <Line name="Meaning">{node.meaning}</Line>
        {node.sort === "number" && <Line name="Allowed">{node.allowed}</Line>}
        {node.sort === "number" && node.usual !== null && <Line name="Default">{node.usual}</Line>}
        <Line name="From">
          <Source origin={node.origin} />
        </Line>
        {back?.given && (
          <Line name="Material">
            {back.given.text}; <Source origin={back.given} />
          </Line>
        )}
        <Line name="Path">
          <code>{node.path}</code>
        </Line>
      </dl>
      {back && (
        <button type="button" onClick={() => void restructure({}, [node.path])}>
          {back.words}
        </button>
      )}
    </div>
  );
}
