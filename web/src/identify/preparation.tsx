// What is done to a log before it is fitted: added by a choice, said in words, taken back by a click.

import { useSignal } from "@preact/signals";
import { NumberField, SECONDS } from "./number.tsx";
import { Said } from "./said.tsx";
import { put, records, state, type Step } from "./state.ts";

interface Kind {
  words: string;
  /** The number that it takes, with its usual value and unit; none for nothing. */
  number?: { key: "width" | "limit" | "rows" | "value" | "interval"; label: string; usual: number; whole?: boolean };
  column: boolean;
}

const KINDS: Record<Step["kind"], Kind> = {
  median: { words: "median filter", number: { key: "width", label: "rows", usual: 5, whole: true }, column: true },
  smooth: { words: "smooth (moving mean)", number: { key: "width", label: "rows", usual: 9, whole: true }, column: true },
  outliers: { words: "leave out outliers", number: { key: "limit", label: "beyond scatters", usual: 6 }, column: true },
  zero: { words: "count from its first rows", number: { key: "rows", label: "rows", usual: 5, whole: true }, column: true },
  offset: { words: "add an offset", number: { key: "value", label: "offset", usual: 0 }, column: true },
  hold: { words: "take its mean", column: true },
  resample: { words: "resample all columns", number: { key: "interval", label: "every [s]", usual: 1 }, column: false },
  cut: { words: "keep only a part of the time", column: false },
};
type Name = keyof typeof KINDS;

const change = (steps: Step[]): void => put({ steps, cuts: [] });

export function Preparation() {
  const kind = useSignal<Name>("median");
  const column = useSignal("");
  const amount = useSignal<number | null>(null);
  const [from, to] = [useSignal<number | null>(null), useSignal<number | null>(null)];
  const found = records.value;
  if (!found) return null;
  const how = KINDS[kind.value];
  const names = found.columns.map((one) => one.name);
  const chosen = names.includes(column.value) ? column.value : (names[0] ?? "");
  const shown = found.columns.find((one) => one.name === chosen);
  const plain = kind.value === "offset" && shown ? { factor: shown.factor, offset: 0, display_unit: shown.display_unit } : { factor: 1, offset: 0, display_unit: "" };
  const { steps } = state.value;
  const add = (): void => {
    const value = amount.value ?? how.number?.usual ?? 0;
    const part = kind.value === "cut" ? { from: from.value ?? found.begin, to: to.value ?? found.end } : {};
    change([...steps, { kind: kind.value, ...(how.column ? { column: chosen } : {}), ...(how.number ? { [how.number.key]: how.number.whole ? Math.round(value) : value } : {}), ...part }]);
    amount.value = from.value = to.value = null;
  };
  return (
    <fieldset class="panel stack">
      <legend>Preparation of the log{steps.length ? "" : ": none"}</legend>
      {steps.length > 0 && (
        <ol class="identify-steps-done">
          {steps.map((step, k) => (
            <li key={`${k} ${step.kind}`} class="row">
              <span>
                <Said>{found.steps[k] ?? `${step.kind} …`}</Said>
              </span>
              <button type="button" aria-label={`Undo step ${k + 1}`} onClick={() => change(steps.filter((_, at) => at !== k))}>
                Undo
              </button>
            </li>
          ))}
        </ol>
      )}
      <div class="row">
        <label>
          Step{" "}
          <select value={kind.value} onChange={(event) => (kind.value = event.currentTarget.value as Name)}>
            {Object.entries(KINDS).map(([name, { words }]) => (
              <option key={name} value={name}>
                {words}
              </option>
            ))}
          </select>
        </label>
        {how.column && (
          <label>
            of{" "}
            <select aria-label="Column of the step" value={chosen} onChange={(event) => (column.value = event.currentTarget.value)}>
              {names.map((name) => (
                <option key={name} value={name}>
                  {name}
                </option>
              ))}
            </select>
          </label>
        )}
        {how.number && <NumberField label={how.number.label} value={amount.value} how={plain} placeholder={String(how.number.usual)} onChange={(value) => (amount.value = value)} />}
        {kind.value === "cut" && (
          <>
            <NumberField label="kept from" value={from.value} how={SECONDS} placeholder={String(Number(found.begin.toPrecision(6)))} onChange={(value) => (from.value = value)} />
            <NumberField label="kept to" value={to.value} how={SECONDS} placeholder={String(Number(found.end.toPrecision(6)))} onChange={(value) => (to.value = value)} />
          </>
        )}
        <button type="button" onClick={add}>
          Apply
        </button>
      </div>
    </fieldset>
  );
}
