// The controls on top, and the way to all others.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { digits } from "../lib/numbers.ts";
import { scaledRow } from "../views/remedies.ts";
import { NumberControl } from "./number.tsx";
import { onTop } from "./pinned.ts";
import { idOf, Row } from "./row.tsx";
import { POSITIONS } from "./scale.ts";
import { grip, slide } from "./state.ts";
import type { RowNode } from "./types.ts";

/** Shares of what the list held first between which its slider goes. */
const [LEAST, MOST] = [0.1, 3];

function largest(text: string): { size: number; unit: string } {
  const parts = text.split(",").map((part) => /^\s*([-+\d.e]+)\s*(.*?)\s*$/i.exec(part));
  return { size: Math.max(...parts.map((part) => Math.abs(Number(part?.[1] ?? 0)))), unit: parts[0]?.[2] ?? "" };
}

/** A list of quantities over time, drawn up or down as a whole. */
function ListControl({ node }: { node: RowNode }) {
  const { size, unit } = largest(node.value);
  const first = useRef(size);
  const draft = useSignal<number | null>(null);
  useEffect(() => void (draft.value = null), [node.value]);
  const shown = draft.value ?? size;
  const [low, high] = [LEAST * first.current, MOST * first.current];
  const move = (event: Event): void => {
    const share = Number((event.currentTarget as HTMLInputElement).value) / POSITIONS;
    const next = Number((low + share * (high - low)).toPrecision(3));
    draft.value = next;
    slide(node.path, scaledRow(node.value, next / size));
  };
  return (
    <Row node={node}>
      <div class="number">
        <input
          id={idOf(node.path)}
          type="range"
          min={0}
          max={POSITIONS}
          value={Math.round((POSITIONS * (shown - low)) / (high - low))}
          aria-label={`${node.title}, slider`}
          aria-valuetext={`${digits(shown, 3)} ${unit}`}
          onPointerDown={grip}
          onInput={move}
        />
        <output class="list-peak">{digits(shown, 3)}</output>
        <span class="unit small">{unit}</span>
      </div>
    </Row>
  );
}

export function TopControls() {
  if (!onTop.value.length) return null;
  return (
    <div class="panel top-controls" role="group" aria-label="Controls on top">
      {onTop.value.map((node) => (node.sort === "row" ? <ListControl key={node.path} node={node} /> : <NumberControl key={node.path} node={node} />))}
    </div>
  );
}
