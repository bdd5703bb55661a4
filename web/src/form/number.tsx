// A number: a slider and a field with its unit.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { faulty, idOf, Row } from "./row.tsx";
import { POSITIONS, positionOf, quantity, stepped, typed, valueAt, written } from "./scale.ts";
import { giveUp, grip, rangeOf, refusals, restructure, returns, send, slide } from "./state.ts";
import type { NumberNode } from "./types.ts";

export function NumberControl({ node }: { node: NumberNode }) {
  /** What is being typed or dragged; null while the number of the form is shown. */
  const draft = useSignal<string | null>(null);
  const slider = rangeOf(node);
  const id = idOf(node.path);
  const shown = draft.value ?? written(node);
  const value = Number.parseFloat(shown);

  /** Whether what is in the field was sent, so that the next form replaces it. */
  const isSent = useRef(false);

  // A new form has come: what was tried is in it, unless it was refused or is still being typed.
  useEffect(() => {
    const typing = document.activeElement?.id === id && !isSent.current;
    if (!typing && !refusals.peek()[node.path]) draft.value = null;
    isSent.current = false;
  }, [node, returns.value]);

  const commit = (): void => {
    const text = draft.peek();
    if (text === null || isSent.current) return;
    isSent.current = true;
    if (text === written(node) && !refusals.peek()[node.path]) return;
    if (text.trim()) send({ [node.path]: typed(node, text) });
    else if (!node.required || node.material) void restructure({}, [node.path]);
    else draft.value = null;
  };
  const onKey = (event: KeyboardEvent): void => {
    const up = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (event.key === "Enter") commit();
    else if (event.key === "Escape") {
      draft.value = null;
      giveUp(node.path);
    } else if (up && Number.isFinite(value)) {
      event.preventDefault();
      const next = stepped(value, up * (event.shiftKey ? 10 : 1), node);
      draft.value = String(next);
      isSent.current = true;
      slide(node.path, quantity(node, next));
    }
  };
  const move = (event: Event): void => {
    if (!slider) return;
    const next = valueAt(node, slider, Number((event.currentTarget as HTMLInputElement).value));
    draft.value = String(next);
    slide(node.path, quantity(node, next));
  };
  return (
    <Row node={node}>
      <div class={`number ${slider ? "" : "alone"}`}>
        {slider && (
          <input
            type="range"
            min={0}
            max={POSITIONS}
            step={1}
            value={Number.isFinite(value) ? positionOf(node, slider, value) : 0}
            aria-label={`${node.title}, slider`}
            aria-valuetext={`${shown} ${node.label}`}
            onPointerDown={grip}
            onInput={move}
          />
        )}
        <input
          id={id}
          type="text"
          inputMode="decimal"
          autocomplete="off"
          spellcheck={false}
          value={shown}
          placeholder={node.value === null || node.unlimited ? "no limit" : ""}
          onInput={(event) => {
            draft.value = event.currentTarget.value;
            isSent.current = false;
          }}
          onChange={commit}
          onKeyDown={onKey}
          {...faulty(node.path)}
        />
        <span class="unit small">{node.label}</span>
      </div>
    </Row>
  );
}
