// Numbers that a kind needs and for which nothing is known: they are asked for.

import { useSignal } from "@preact/signals";
import { Message } from "../ui/message.tsx";
import { idOf, nameOf } from "./row.tsx";
import { typed } from "./scale.ts";
import { restructure, wanting } from "./state.ts";
import type { SingleNode } from "./types.ts";

export function Wanting() {
  const given = useSignal<Record<string, string>>({});
  const fault = useSignal("");
  const now = wanting.value;
  if (!now) return null;
  const meant = (node: SingleNode): unknown => {
    const text = given.value[node.path] ?? "";
    return node.sort === "number" ? typed(node, text) : text;
  };
  const apply = async (event: Event): Promise<void> => {
    event.preventDefault();
    const numbers = Object.fromEntries(now.missing.map((node) => [node.path, meant(node)]));
    fault.value = await restructure({ ...now.changes, ...numbers });
  };
  return (
    <form class="panel stack wanting" aria-label="Missing numbers" onSubmit={(event) => void apply(event)}>
      <Message kind="note">{now.sentence}</Message>
      {now.missing.map((node) => (
        <div key={node.path} class="form-row">
          <label for={`${idOf(node.path)}-new`} title={node.meaning}>
            {nameOf(node)} <span class="small">{node.meaning}</span>
          </label>
          <div class="number alone">
            <input
              id={`${idOf(node.path)}-new`}
              type="text"
              required
              autocomplete="off"
              value={given.value[node.path] ?? ""}
              onInput={(event) => (given.value = { ...given.value, [node.path]: event.currentTarget.value })}
            />
            <span class="unit small">{node.sort === "number" ? node.label : ""}</span>
          </div>
          {node.sort === "number" && <p class="small soft">{node.allowed}</p>}
        </div>
      ))}
      {fault.value && <Message kind="error">{fault.value}</Message>}
      <div class="row">
        <button type="submit" class="main">
          Apply
        </button>
        <button type="button" onClick={() => (wanting.value = null)}>
          Cancel
        </button>
      </div>
    </form>
  );
}
