// The third step: the scenario that is to explain the log, what is free in it, and how to search.

import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { call } from "../lib/api.ts";
import { text as benchText } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { Numbers } from "./numbers.tsx";
import { Options } from "./options.tsx";
import { Said } from "./said.tsx";
import { beginFit, proposal, put, readScenario, refused, scenario, simplest, state, takeModel } from "./state.ts";
import { Select } from "../ui/select.tsx";

interface Listed {
  scenarios: { name: string; title: string; text: string }[];
}

async function taken(text: string, origin: string): Promise<void> {
  put({ text, origin, free: {}, ignored: [], each: [], proposed: "" });
  scenario.value = null;
  await readScenario();
}

function Choose() {
  const listed = useSignal<Listed["scenarios"]>([]);
  useEffect(() => {
    const load = async (): Promise<void> => {
      const [follow, others] = await Promise.all([call<Listed>("fit_starts"), call<Listed>("scenarios")]);
      listed.value = [...follow.scenarios.map((one) => ({ ...one, title: `${one.title} (follows a log)` })), ...others.scenarios];
    };
    load().catch((error: unknown) => (refused.value = String(error)));
  }, []);
  const file = async (given: File | undefined): Promise<void> => {
    if (given) await taken(await given.text(), given.name);
  };
  return (
    <div class="panel row">
      <label>
        Scenario{" "}
        <Select
          value=""
          onChange={(event) => {
            const one = listed.value.find((each) => each.name === event.currentTarget.value);
            if (one) void taken(one.text, "");
          }}
        >
          <option value="">choose a packaged one …</option>
          {listed.value.map((one) => (
            <option key={one.name} value={one.name}>
              {one.title}
            </option>
          ))}
        </Select>
      </label>
      <button type="button" disabled={!benchText.value} onClick={() => void taken(benchText.value, "the bench")}>
        Use the scenario on the bench
      </button>
      <label>
        or a file (TOML) <input type="file" accept=".toml" onChange={(event) => void file(event.currentTarget.files?.[0])} />
      </label>
    </div>
  );
}

/** Scenarios that may explain what was recognised; one click takes one with what is free. */
function Proposed() {
  const found = proposal.value;
  if (!found) return null;
  if (found.refused) return <p class="soft small">No scenario is proposed: {found.refused.replaceAll("`", "")}</p>;
  const best = simplest(found)?.name;
  return (
    <fieldset class="panel stack">
      <legend>Proposed for these logs</legend>
      <p class="small">
        <Said>{[found.said, ...found.notes].join(" ")}</Said>
      </p>
      <div class="row">
        {found.models.map((model) => (
          <button key={model.name} type="button" aria-pressed={state.value.proposed === model.name} onClick={() => void takeModel(model)}>
            {model.name}, {model.free.length} numbers{model.name === best ? " (simplest)" : ""}
          </button>
        ))}
      </div>
    </fieldset>
  );
}

function Document() {
  const draft = useSignal<string | null>(null);
  return (
    <details class="panel">
      <summary>The scenario as text</summary>
      <textarea
        class="identify-text"
        aria-label="Scenario, TOML"
        spellcheck={false}
        rows={16}
        value={draft.value ?? state.value.text}
        onInput={(event) => (draft.value = event.currentTarget.value)}
      />
      <button
        type="button"
        disabled={draft.value === null}
        onClick={() => {
          put({ text: draft.value ?? state.value.text });
          draft.value = null;
          void readScenario();
        }}
      >
        Apply the changes
      </button>
    </details>
  );
}

/** What drives, and which column each follows. */
function Drives() {
  const found = scenario.value;
  if (!found) return null;
  const columns = Object.keys(found.columns);
  return (
    <fieldset class="panel">
      <legend>Drives of the test</legend>
      {found.drives.map((drive) => (
        <div class="row" key={drive.path}>
          <span>
            {drive.what.replaceAll("`", "")}
            <span class="soft small"> {drive.waveform === "log" ? `follows ${drive.column || "a column of the log"}` : `has a waveform of its own: ${drive.waveform}`}</span>
          </span>
          <label>
            follow the column{" "}
            <Select
              aria-label={`Column that ${drive.path} follows`}
              value={drive.waveform === "log" ? drive.column : ""}
              onChange={(event) => event.currentTarget.value && void readScenario({ path: drive.path, column: event.currentTarget.value })}
            >
              <option value="">–</option>
              {columns.map((name) => (
                <option key={name} value={name}>
                  {name}
                </option>
              ))}
            </Select>
          </label>
        </div>
      ))}
    </fieldset>
  );
}

export function ScenarioStep() {
  const found = scenario.value;
  const { text, origin, free } = state.value;
  const count = Object.keys(free).length;
  const ready = found !== null && !found.refused && count > 0;
  return (
    <div class="stack">
      <Proposed />
      <Choose />
      {found && text && (
        <>
          <h2>
            {found.title || "Scenario"} <span class="soft small">{[found.described, origin && `from ${origin}`].filter(Boolean).join("; ")}</span>
          </h2>
          <Drives />
          {found.refused && <Message kind="error">{found.refused}</Message>}
          {found.notes?.map((note) => (
            <Message key={note} kind="note">
              {note}
            </Message>
          ))}
          <Document />
          {found.numbers.length > 0 && (
            <>
              <Numbers />
              <Options />
              <div class="row identify-begin">
                <button type="button" class="main" disabled={!ready} onClick={() => void beginFit()}>
                  Fit {count} parameter{count === 1 ? "" : "s"}
                </button>
                {!count && <span class="soft">Choose at least one parameter to fit.</span>}
              </div>
            </>
          )}
        </>
      )}
      {!text && <p class="soft">The scenario describes the test and the law. The fit finds its free parameters.</p>}
    </div>
  );
}
