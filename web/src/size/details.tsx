// One wire: in words, with its margins, and as a scenario.

import { save } from "../lib/api.ts";
import { openInBench } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { Circuit } from "./circuit.tsx";
import { fileName } from "./state.ts";
import { Margins } from "./margins.tsx";
import type { Candidate } from "./types.ts";

function Scenario({ found }: { found: Candidate }) {
  const text = found.scenario;
  if (text === null) return <p class="small soft">{found.no_scenario}</p>;
  return (
    <div class="row">
      <button type="button" class="main" onClick={() => openInBench(text)}>
        Open in bench
      </button>
      <button type="button" onClick={() => save(fileName(found), text)}>
        Save scenario
      </button>
      {found.loop && (
        <button type="button" onClick={() => openInBench(found.loop ?? "")} title="A transistor, a position sensor and a PID controller around it">
          Open in a loop
        </button>
      )}
    </div>
  );
}

export function Details({ found, number }: { found: Candidate; number: number }) {
  return (
    <section class="panel stack size-details" aria-label="Chosen wire">
      <h2>
        {number}: {found.size}, {found.alloy} °C
      </h2>
      <p>{found.headline}</p>
      {found.reasons.map((reason) => (
        <Message key={reason} kind="error">
          Not met: {reason}.
        </Message>
      ))}
      <Scenario found={found} />
      <Circuit found={found} />
      <Margins margins={found.margins} />
      <ul class="sentences">
        {found.sentences.map((sentence) => (
          <li key={sentence}>{sentence}</li>
        ))}
      </ul>
      {found.warnings.map((warning) => (
        <Message key={warning} kind="caution">
          Warning: {warning}.
        </Message>
      ))}
      {found.frail.map((words) => (
        <Message key={words} kind="note">
          Not robust: {words}.
        </Message>
      ))}
      {found.doubts.map((doubt) => (
        <p key={doubt} class="small soft">
          {doubt}
        </p>
      ))}
    </section>
  );
}
