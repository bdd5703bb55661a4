// A list of numbers that can be varied, narrowed by what is typed.

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Words } from "../studies/words.tsx";
import { addAxis, choices, form, labelOf } from "./asking.ts";
import type { Target } from "./types.ts";

const MOST = 60;

function fits(one: Target, words: string[]): boolean {
  const all = `${labelOf(one.name)} ${one.name} ${one.about}`.toLowerCase();
  return words.every((word) => all.includes(word));
}

const bounds = ({ low, high, open, unit }: Target): string => {
  const shown = (value: number | null): string => (value === null ? "" : String(Number(value.toPrecision(4))));
  if (low === null && high === null) return "";
  if (high === null) return `${open ? "above" : "from"} ${shown(low)} ${unit}`;
  if (low === null) return `up to ${shown(high)} ${unit}`;
  return `${shown(low)} to ${shown(high)} ${unit}`;
};

export function Picker() {
  const typed = useSignal("");
  const open = useSignal(false);
  /** Place of the number that Enter takes; the arrow keys move it. */
  const active = useSignal(0);
  const field = useRef<HTMLInputElement>(null);
  const taken = new Set(choices.value.axes.map((axis) => axis.name));
  const matching = (): Target[] => {
    const words = typed.value.toLowerCase().split(/\s+/).filter(Boolean);
    return (form.value?.targets ?? []).filter((one) => !taken.has(one.name) && fits(one, words));
  };
  const found = matching();
  const shut = (): void => {
    field.current?.focus(); // which opens it
    open.value = false;
  };
  const take = (one: Target): void => {
    addAxis(one);
    typed.value = "";
    shut();
  };
  const show = (): void => {
    open.value = true;
    active.value = 0;
  };
  const press = (event: KeyboardEvent): void => {
    const last = Math.min(found.length, MOST) - 1;
    const moves: Record<string, number> = { ArrowDown: active.value + 1, ArrowUp: active.value - 1, Home: 0, End: last };
    const next = moves[event.key];
    if (event.key === "Escape") shut();
    else if (event.key === "Enter") found.slice(active.value, active.value + 1).forEach(take);
    else if (next !== undefined && open.value && last >= 0) {
      event.preventDefault();
      active.value = Math.min(Math.max(next, 0), last);
      document.getElementById(`sweep-found-${active.value}`)?.scrollIntoView({ block: "nearest" });
    } else if (event.key === "ArrowDown") show();
  };
  const left = (event: FocusEvent): void => {
    const to = event.relatedTarget;
    if (!(to instanceof Node && event.currentTarget instanceof Node && event.currentTarget.contains(to))) open.value = false;
  };
  return (
    <div class="sweep-picker" onFocusOut={left}>
      <label for="sweep-search">Add a parameter to vary</label>
      <input
        id="sweep-search" ref={field} type="search" autocomplete="off" placeholder="diameter, A_s, duty …" value={typed.value}
        role="combobox" list={undefined} aria-autocomplete="list" aria-expanded={open.value} aria-controls="sweep-found"
        aria-activedescendant={open.value && found.length ? `sweep-found-${active.value}` : undefined}
        onFocus={show} onClick={show} onKeyDown={press}
        onInput={(event) => {
          typed.value = event.currentTarget.value;
          show();
        }}
      />
      <ul id="sweep-found" class="sweep-found" role="listbox" aria-label="Parameters of the scenario" hidden={!open.value || !found.length}>
        {open.value && found.slice(0, MOST).map((one, k) => (
          <li
            key={one.name} id={`sweep-found-${k}`} role="option" aria-selected={k === active.value}
            onMouseDown={(event) => event.preventDefault()} onClick={() => take(one)}
          >
            <strong>{labelOf(one.name)}</strong> <span>{one.words}</span>
            <small class="soft">
              {one.name}: <Words text={one.about} />
              {bounds(one) && ` (${bounds(one)})`}
            </small>
          </li>
        ))}
      </ul>
      {open.value && <p class="sweep-found-more soft" role="status">{counted(found.length, form.value !== null)}</p>}
    </div>
  );
}

/** Numbers that are varied most. */
const USUAL = [/^element\.(\w+\.)?diameter$/, /^(drives?|references?)\..*(high|value|amplitude)$/, /^mechanism\.(mass|force|preload)$/, /^environment\.temperature$/];

/** Some numbers at hand while nothing is varied yet. */
export function Suggested() {
  const targets = form.value?.targets ?? [];
  const found = USUAL.flatMap((name) => targets.find((one) => name.test(one.name)) ?? []).slice(0, 3);
  if (choices.value.axes.length || !found.length) return null;
  return (
    <p class="row small sweep-suggested">
      such as
      {found.map((one) => (
        <button key={one.name} type="button" onClick={() => addAxis(one)} title={`${one.name}: ${one.about}`}>
          {labelOf(one.name)}
        </button>
      ))}
    </p>
  );
}

/** What is not in the list, in words. */
function counted(found: number, known: boolean): string {
  if (!known) return "Reading the scenario …";
  if (!found) return "No parameter with this name can be varied.";
  return found > MOST ? `${found - MOST} more; type to narrow them.` : `${found} found; the arrow keys choose.`;
}
