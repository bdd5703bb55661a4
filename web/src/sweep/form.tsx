// The form: scenario, axes, sample, outputs, and how it is run.

import { Message } from "../ui/message.tsx";
import { Axes } from "./axes.tsx";
import { BENCH, choices, choose, fault, form, packaged, put, trouble } from "./asking.ts";
import { Choice, Field, Wrong } from "./field.tsx";
import { Outputs } from "./outputs.tsx";
import { Picker, Suggested } from "./picker.tsx";
import { Start } from "./start.tsx";

function Source() {
  return (
    <>
      <Choice id="sweep-source" label="Scenario" value={choices.value.source} onChange={choose}>
        <option value={BENCH}>Scenario on the bench</option>
        {packaged.value.map((one) => (
          <option key={one.name} value={one.name}>
            {one.title}
          </option>
        ))}
      </Choice>
      {form.value && choices.value.source === BENCH && <p class="small">{form.value.title}</p>}
    </>
  );
}

function Sample() {
  const { design, count, seed } = choices.value;
  const known = form.value?.designs ?? [];
  const about = known.find((one) => one.name === design)?.about;
  return (
    <>
      <div class="sweep-line">
        <Choice id="sweep-design" label="Sample" value={design} onChange={(value) => put({ design: value })}>
          {known.map((one) => (
            <option key={one.name} value={one.name}>
              {one.name}
            </option>
          ))}
        </Choice>
        {design !== "grid" && (
          <>
            <Field narrow id="sweep-count" label="Number" value={count} onChange={(value) => put({ count: value })} />
            <Field narrow id="sweep-seed" label="Seed" value={seed} wrong={fault("seed")} onChange={(value) => put({ seed: value })} />
          </>
        )}
      </div>
      {about && <p class="soft small">{about}</p>}
      <Wrong id="sweep-design">{fault("sample")}</Wrong>
    </>
  );
}

function How() {
  const { runtime, workers, step } = choices.value;
  const known = form.value;
  return (
    <details>
      <summary>How it is run</summary>
      <div class="sweep-line">
        <Choice id="sweep-runtime" label="Runtime" value={runtime} wrong={fault("runtime")} onChange={(value) => put({ runtime: value })}>
          <option value="">as it suits</option>
          {known?.runtimes.map((name) => (
            <option key={name} value={name}>
              {name}
            </option>
          ))}
        </Choice>
        <Field
          narrow id="sweep-workers" label="Processes" value={workers} wrong={fault("workers")}
          onChange={(value) => put({ workers: value })}
        />
        <Field
          narrow id="sweep-step" label="Longest step" hint="by tolerance" value={step} wrong={fault("step")}
          onChange={(value) => put({ step: value })}
        />
      </div>
      <p class="soft small">Processes: 0 for one per core ({known?.cores ?? "–"} here).</p>
    </details>
  );
}

export function Form() {
  return (
    <form class="panel stack sweep-form" onSubmit={(event) => event.preventDefault()}>
      <h2>New sweep</h2>
      {trouble.value && <Message kind="error">{trouble.value}</Message>}
      <section aria-label="Scenario">
        <Source />
      </section>
      <section class="stack" aria-label="Axes">
        <Picker />
        <Suggested />
        <Axes />
      </section>
      <section aria-label="Sample">
        <Sample />
      </section>
      <section aria-label="Outputs">
        <h3>Stored for every run</h3>
        <Outputs />
      </section>
      <How />
      <Wrong id="sweep-whole">{fault("")}</Wrong>
      <Start />
    </form>
  );
}
