// A picture of runs over two scales: one is chosen by pointer or keys.

import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { Chart } from "../plots/chart.tsx";
import type { Picture } from "../plots/picture.ts";
import { openRun } from "./bench.ts";
import { chosen } from "./shown.ts";

export function Plane({ picture, label, onLook }: { picture: Picture; label: string; onLook: (row: number | null) => void }) {
  const over = useSignal<number | null>(null);
  const marked = [chosen.value, over.value];
  const shown = useMemo<Picture>(() => {
    const rings = marked.flatMap((row) => (picture.spots ?? []).find((spot) => spot.row === row) ?? []);
    return { ...picture, rings };
  }, [picture, ...marked]);
  const look = (row: number | null): void => {
    over.value = row;
    onLook(row);
  };
  const press = (event: KeyboardEvent): void => {
    if (event.key === "Enter" && chosen.value !== null && (event.target as HTMLElement).classList.contains("chart-over")) void openRun(chosen.value);
    if (event.key === "Escape") chosen.value = null;
  };
  return (
    <div class="sweep-canvas" onKeyDown={press}>
      <Chart
        picture={shown} about={label} keys="Arrow keys move from run to run, Enter opens one in the bench."
        onLook={(found) => look(found?.spot?.row ?? null)} onPick={(_x, _y, found) => (chosen.value = found?.spot?.row ?? null)}
      />
    </div>
  );
}
