// What is compared, what every record has for itself, what is kept back, and how to search.

import { heldNames, put, scenario, state } from "./state.ts";
import { Select } from "../ui/select.tsx";

const without = (list: string[], name: string): string[] => list.filter((one) => one !== name);
const toggled = (list: string[], name: string): string[] => (list.includes(name) ? without(list, name) : [...list, name]);

function Compared() {
  const outputs = scenario.value?.outputs ?? [];
  const { ignored } = state.value;
  return (
    <div class="row">
      <span>Compared with the log:</span>
      {outputs.map(({ name }) => (
        <label key={name}>
          <input
            type="checkbox"
            checked={!ignored.includes(name)}
            disabled={!ignored.includes(name) && ignored.length === outputs.length - 1}
            onChange={() => put({ ignored: toggled(ignored, name) })}
          />{" "}
          {name}
        </label>
      ))}
    </div>
  );
}

function OfRecords() {
  const { each, ignored } = state.value;
  const offsets = (scenario.value?.outputs ?? []).filter((one) => !ignored.includes(one.name)).map((one) => `offset.${one.name}`);
  return (
    <div class="row">
      <span>Separate values for each log:</span>
      {[...offsets, "delay", "initial_fraction"].map((name) => (
        <label key={name}>
          <input type="checkbox" checked={each.includes(name)} onChange={() => put({ each: toggled(each, name) })} />{" "}
          {name.startsWith("offset.") ? `zero of ${name.slice(7)}` : name.replaceAll("_", " ")}
        </label>
      ))}
    </div>
  );
}

interface PickProps {
  label: string;
  value: string;
  choices: Record<string, string>;
  onPick: (value: string) => void;
}

function Pick({ label, value, choices, onPick }: PickProps) {
  return (
    <label>
      {label}{" "}
      <Select value={value} title={choices[value]} onChange={(event) => onPick(event.currentTarget.value)}>
        {Object.entries(choices).map(([name, words]) => (
          <option key={name} value={name}>
            {words ? `${name}: ${words}` : name}
          </option>
        ))}
      </Select>
    </label>
  );
}

const HOLD_OUT = {
  auto: "four stretches of each record; of three and more records the middle one",
  none: "nothing",
  "25 %": "the last quarter of each record",
};

export function Options() {
  const { holdOut } = state.value;
  const held = heldNames.value;
  return (
    <fieldset class="panel stack">
      <legend>How to fit</legend>
      <Compared />
      <OfRecords />
      {held.length ? (
        <p class="small">Held out to test the prediction: {held.join(", ")}.</p>
      ) : (
        <Pick label="Hold out" value={holdOut} choices={HOLD_OUT} onPick={(value) => put({ holdOut: value })} />
      )}
      <Searches />
    </fieldset>
  );
}

function Searches() {
  const { method, loss, starts } = state.value;
  const found = scenario.value;
  return (
    <div class="row">
      <Pick label="Method" value={method} choices={found?.methods ?? {}} onPick={(value) => put({ method: value })} />
      <Pick label="Loss" value={loss} choices={found?.losses ?? {}} onPick={(value) => put({ loss: value })} />
      <label>
        Further starts{" "}
        <input type="number" min={0} max={64} class="narrow" value={starts} onChange={(event) => put({ starts: Math.min(64, Math.max(0, Math.round(Number(event.currentTarget.value)) || 0)) })} />
      </label>
    </div>
  );
}
