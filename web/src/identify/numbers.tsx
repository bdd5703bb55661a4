// All numbers of the scenario: which are free, from where and between which bounds they are searched.

import { useSignal } from "@preact/signals";
import { digits, toShown } from "../lib/numbers.ts";
import { NumberField, printed } from "./number.tsx";
import { proposal, put, scenario, state, type Choice } from "./state.ts";
import type { Quantity } from "./types.ts";

function set(name: string, choice: Choice | null): void {
  const { [name]: _, ...others } = state.value.free;
  put({ free: choice ? { ...others, [name]: choice } : others });
}

function Row({ one }: { one: Quantity }) {
  const choice = state.value.free[one.name];
  const label = one.name.split(".").at(-1) ?? one.name;
  const field = (key: "start" | "low" | "high", words: string, usual: number | null): preact.JSX.Element => (
    <td>
      {choice && (
        <NumberField
          hideLabel
          label={`${label}: ${words}`}
          value={choice[key]}
          how={one}
          placeholder={usual === null ? "needed" : digits(toShown(usual, one), 5)}
          onChange={(value) => set(one.name, { ...choice, [key]: value })}
        />
      )}
    </td>
  );
  return (
    <tr class={choice ? "free" : ""}>
      <th scope="row">
        <label title={`${one.doc}; allowed: ${one.allowed}`}>
          <input type="checkbox" checked={choice !== undefined} onChange={(event) => set(one.name, event.currentTarget.checked ? { start: null, low: null, high: null } : null)} />{" "}
          {one.name}
        </label>
      </th>
      <td class="right">
        {digits(toShown(one.value, one), 5)} {printed(one.display_unit)}
      </td>
      {field("start", "start", one.value)}
      {field("low", "lower bound", one.low)}
      {field("high", "upper bound", one.high)}
      <td class="small">
        {one.doc}
        {one.places > 1 && ` (in ${one.places} places, moved together)`}
        <span class="soft"> – {one.origin || one.group}</span>
      </td>
    </tr>
  );
}

/** Free differences of a proposal, such as A_s less A_f, which keep the order of both. */
function differences(): Quantity[] {
  const models = proposal.value?.models.find((one) => one.name === state.value.proposed)?.free ?? [];
  const known = new Set(scenario.value?.numbers.map((one) => one.name));
  return models
    .filter((one) => !known.has(one.name))
    .map(({ name, doc, usual: [value, low, high], unit, display_unit, factor, offset }) => ({
      name, doc, value, low, high, unit, display_unit, factor, offset, group: "differences", places: 1, allowed: "finite", origin: "proposed",
    }));
}

const HEADINGS = ["free", "in the scenario", "start", "lower bound", "upper bound", "meaning"];

export function Numbers() {
  const sought = useSignal("");
  const onlyFree = useSignal(false);
  const words = sought.value.toLowerCase();
  const numbers = [...differences(), ...(scenario.value?.numbers ?? [])].filter(
    (one) => (!onlyFree.value || one.name in state.value.free) && `${one.group}.${one.name} ${one.doc}`.toLowerCase().includes(words),
  );
  const groups = [...new Set(numbers.map((one) => one.group))].sort((a, b) => Number(b.includes("law")) - Number(a.includes("law")));
  return (
    <fieldset class="panel">
      <legend>Free parameters</legend>
      <div class="row">
        <label>
          Find <input type="search" value={sought.value} onInput={(event) => (sought.value = event.currentTarget.value)} />
        </label>
        <label>
          <input type="checkbox" checked={onlyFree.value} onChange={(event) => (onlyFree.value = event.currentTarget.checked)} /> only those that are free
        </label>
        <span class="soft small">Empty fields use the start value of the scenario and the grey bounds.</span>
      </div>
      <div class="scrolling identify-numbers" tabIndex={0} role="region" aria-label="Parameters of the scenario">
        <table>
          <thead>
            <tr>
              {HEADINGS.map((name) => (
                <th key={name} scope="col">
                  {name}
                </th>
              ))}
            </tr>
          </thead>
          {groups.map((group) => (
            <tbody key={group}>
              <tr>
                <th colSpan={6} scope="rowgroup" class="identify-group">
                  {group}
                </th>
              </tr>
              {numbers
                .filter((one) => one.group === group)
                .map((one) => (
                  <Row key={one.name} one={one} />
                ))}
            </tbody>
          ))}
        </table>
      </div>
    </fieldset>
  );
}
