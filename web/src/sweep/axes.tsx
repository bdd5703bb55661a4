// The axes: what is varied, and over which numbers.

import type { AxisChoice, Kind } from "./axis.ts";
import { Words } from "../studies/words.tsx";
import { changeAxis, choices, fault, labelOf, removeAxis, targetOf } from "./asking.ts";
import { Field, Wrong } from "./field.tsx";

const KINDS: [Kind, string][] = [
  ["range", "Range"],
  ["list", "List"],
  ["normal", "Tolerance"],
];

function Range({ axis, grid }: { axis: AxisChoice; grid: boolean }) {
  const id = `axis-${axis.id}`;
  const put = (some: Partial<AxisChoice>): void => changeAxis(axis.id, some);
  return (
    <div class="sweep-line">
      <Field narrow id={`${id}-low`} label="From" value={axis.low} onChange={(low) => put({ low })} />
      <Field narrow id={`${id}-high`} label="to" value={axis.high} onChange={(high) => put({ high })} />
      <Field narrow id={`${id}-unit`} label="Unit" value={axis.unit} onChange={(unit) => put({ unit })} />
      {grid && <Field narrow id={`${id}-levels`} label="Levels" value={axis.levels} onChange={(levels) => put({ levels })} />}
      <label class="sweep-check">
        <input type="checkbox" checked={axis.log} onChange={(event) => put({ log: event.currentTarget.checked })} /> log scale
      </label>
    </div>
  );
}

function List({ axis }: { axis: AxisChoice }) {
  const id = `axis-${axis.id}`;
  return (
    <div class="sweep-line">
      <Field id={`${id}-list`} label="Numbers" value={axis.list} onChange={(list) => changeAxis(axis.id, { list })} />
      <Field narrow id={`${id}-unit`} label="Unit" value={axis.unit} onChange={(unit) => changeAxis(axis.id, { unit })} />
    </div>
  );
}

function Normal({ axis }: { axis: AxisChoice }) {
  const id = `axis-${axis.id}`;
  const put = (some: Partial<AxisChoice>): void => changeAxis(axis.id, some);
  return (
    <>
      <div class="sweep-line">
        <Field narrow id={`${id}-mean`} label="Mean" value={axis.mean} onChange={(mean) => put({ mean })} />
        <Field narrow id={`${id}-unit`} label="Unit" value={axis.unit} onChange={(unit) => put({ unit })} />
        <Field narrow id={`${id}-deviation`} label="±" value={axis.deviation} onChange={(deviation) => put({ deviation })} />
        <Field narrow id={`${id}-of`} label="of" value={axis.deviationUnit} onChange={(deviationUnit) => put({ deviationUnit })} />
      </div>
      <p class="soft small">A normal distribution: mean and standard deviation, in a unit or in %.</p>
    </>
  );
}

function One({ axis, place, grid }: { axis: AxisChoice; place: number; grid: boolean }) {
  const about = targetOf(axis.name);
  const shapes = { range: <Range axis={axis} grid={grid} />, list: <List axis={axis} />, normal: <Normal axis={axis} /> };
  return (
    <fieldset class="sweep-axis">
      <legend>
        {labelOf(axis.name)} <code class="soft small">{axis.name}</code>
      </legend>
      <button type="button" class="quiet sweep-remove" aria-label={`Remove ${axis.name}`} onClick={() => removeAxis(axis.id)}>
        ×
      </button>
      {about && (
        <p class="soft small">
          <Words text={about.about} />; now {about.words}
        </p>
      )}
      <div class="sweep-kinds" role="radiogroup" aria-label={`How ${axis.name} is varied`}>
        {KINDS.map(([kind, words]) => (
          <label key={kind}>
            <input
              type="radio" name={`kind-${axis.id}`} checked={axis.kind === kind}
              onChange={() => changeAxis(axis.id, { kind })}
            />{" "}
            {words}
          </label>
        ))}
      </div>
      {shapes[axis.kind]}
      <Wrong id={`axis-${axis.id}`}>{fault(`over.${place}`)}</Wrong>
    </fieldset>
  );
}

export function Axes() {
  const { axes, design } = choices.value;
  return (
    <>
      {axes.map((axis, place) => (
        <One key={axis.id} axis={axis} place={place} grid={design === "grid"} />
      ))}
    </>
  );
}
