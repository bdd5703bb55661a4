// A list of numbers that can be varied, narrowed by what is typed.

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { addAxis, choices, form } from "./asking.ts";
import type { Target } from "./types.ts";

const MOST = 60;

function fits(one: Target, words: string[]): boolean {
  const all = `${one.name} ${one.about}`.toLowerCase();
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
  const close = (event: KeyboardEvent): void => {
    if (event.key === "Escape") shut();
  };
  const left = (event: FocusEvent): void => {
    const to = event.relatedTarget;
    if (!(to instanceof Node && event.currentTarget instanceof Node && event.currentTarget.contains(to))) open.value = false;
  };
  return (
    <div class="sweep-picker" onKeyDown={close} onFocusOut={left}>
      <label for="sweep-search">Add a number to vary</label>
      <input
        id="sweep-search" ref={field} type="search" autocomplete="off" placeholder="diameter, A_s, duty …"
        value={typed.value} aria-expanded={open.value} aria-controls="sweep-found"
        onFocus={() => (open.value = true)} onClick={() => (open.value = true)}
        onInput={(event) => ((typed.value = event.currentTarget.value), (open.value = true))}
        onKeyDown={(event) => event.key === "Enter" && matching().slice(0, 1).forEach(take)}
      />
      {open.value && (
        <ul id="sweep-found" class="sweep-found" aria-label="Numbers of the scenario">
          {found.slice(0, MOST).map((one) => (
            <li key={one.name}>
              <button type="button" class="quiet" onClick={() => take(one)}>
                <strong>{one.name}</strong> <span>{one.words}</span>
                <small class="soft">
                  {one.about}
                  {bounds(one) && ` (${bounds(one)})`}
                </small>
              </button>
            </li>
          ))}
          {!found.length && <li class="soft">{form.value ? "Nothing of that name can be varied." : "Reading the scenario …"}</li>}
          {found.length > MOST && <li class="soft">{found.length - MOST} more; type to narrow them.</li>}
        </ul>
      )}
    </div>
  );
}
