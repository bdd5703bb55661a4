// What is kept of every run: measures, one number each.

import { useSignal } from "@preact/signals";
import { choices, fault, form, put } from "./asking.ts";
import { Choice, Wrong } from "./field.tsx";

function Kept({ words, place }: { words: string; place: number }) {
  const drop = (): void => put({ measures: choices.value.measures.filter((one) => one !== words) });
  return (
    <li>
      <span class="sweep-chip">
        {words}
        <button type="button" class="quiet" aria-label={`Remove ${words}`} onClick={drop}>
          ×
        </button>
      </span>
      <Wrong id={`measure-${place}`}>{fault(`measures.${place}`)}</Wrong>
    </li>
  );
}

export function Outputs() {
  const measure = useSignal("max");
  const output = useSignal("");
  const known = form.value;
  const kind = known?.measures.find((one) => one.name === measure.value);
  if (!known) return null;
  const add = (): void => {
    const words = output.value ? `${measure.value}(${output.value})` : measure.value;
    if (!choices.value.measures.includes(words)) put({ measures: [...choices.value.measures, words] });
  };
  return (
    <>
      <ul class="sweep-chips" aria-label="Stored for every run">
        {choices.value.measures.map((words, place) => (
          <Kept key={words} words={words} place={place} />
        ))}
      </ul>
      <div class="sweep-line">
        <Choice id="sweep-measure" label="Measure" value={measure.value} onChange={(value) => (measure.value = value)}>
          {known.measures.map((one) => (
            <option key={one.name} value={one.name} title={one.about}>
              {one.name}
            </option>
          ))}
        </Choice>
        <Choice id="sweep-output" label="of" value={output.value} onChange={(value) => (output.value = value)}>
          <option value="">{kind?.usual ?? ""}</option>
          {known.outputs.map((one) => (
            <option key={one.name} value={one.name} title={one.about}>
              {one.name}
            </option>
          ))}
        </Choice>
        <button type="button" onClick={add}>
          Keep
        </button>
      </div>
      {kind && <p class="soft small">{kind.about}</p>}
    </>
  );
}
