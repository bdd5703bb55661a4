// All studies, each with its source and, once it was computed, its verdicts.

import { useEffect } from "preact/hooks";
import { Message } from "../ui/message.tsx";
import { Thumbnail } from "./figure.tsx";
import { StudyProgress } from "./progress.tsx";
import { list, listed, running, trouble } from "./state.ts";
import type { Listed } from "./types.ts";
import { describeTally, TallyLine } from "./verdict.tsx";

function Card({ study }: { study: Listed }) {
  const source = study.sources[0];
  return (
    <li class="panel stack">
      {study.drawn && <Thumbnail name={study.name} />}
      <h2>
        <a href={`#/studies/${encodeURIComponent(study.name)}`}>{study.title}</a>
      </h2>
      {source && <p class="small soft">{source.text}</p>}
      {study.tally && <p>{describeTally(study.tally)}</p>}
      <p class="small">
        {study.tally ? <TallyLine tally={study.tally} /> : <span class="soft">Not computed yet.</span>}
        {study.missing.length > 0 && <span class="soft"> Some measured data are not on this machine.</span>}
      </p>
    </li>
  );
}

export function StudyList() {
  useEffect(() => void list(), [running.value]);
  const found = listed.value;
  return (
    <div class="stack studies">
      <div>
        <h1>Studies</h1>
        <p class="soft">
          Published results compared with new computations: each printed value next to the computed value, with a verdict. Misprints and
          contradictions are marked.
        </p>
      </div>
      {trouble.value && <Message kind="error">{trouble.value}</Message>}
      <StudyProgress name="" />
      {found ? (
        <ul class="cards">
          {found.map((study) => (
            <Card key={study.name} study={study} />
          ))}
        </ul>
      ) : (
        !trouble.value && <p class="starting">Loading …</p>
      )}
    </div>
  );
}
