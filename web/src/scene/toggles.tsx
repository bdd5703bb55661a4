// The menu of what the picture shows besides the mechanism: names, forces, and long parts in full length.

import { useSignal } from "@preact/signals";
import { Menu } from "../plots/menu.tsx";
import type { Stage } from "./stage.ts";

interface Props {
  stage: { current: Stage | null };
  /** Whether long parts are drawn broken unless asked otherwise. */
  broken: boolean;
  whole: boolean;
  choose: (whole: boolean) => void;
}

export function Toggles({ stage, broken, whole, choose }: Props) {
  const [named, forces] = [useSignal(false), useSignal(false)];
  const switched = (of: typeof named, key: "named" | "forces") => (): void => {
    of.value = !of.value;
    stage.current?.look({ [key]: of.value });
  };
  return (
    <Menu name="Show">
      <div class="stack scene-shows">
        <button type="button" aria-pressed={named.value} title="Names and values of all parts" onClick={switched(named, "named")}>
          Names
        </button>
        <button type="button" aria-pressed={forces.value} title="Forces as arrows with proportional length" onClick={switched(forces, "forces")}>
          Forces
        </button>
        {broken && (
          <button type="button" aria-pressed={whole} title="Long straight parts in full length, or shortened" onClick={() => choose(!whole)}>
            Whole length
          </button>
        )}
      </div>
    </Menu>
  );
}
