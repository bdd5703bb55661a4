// One study: what it is about, scenarios for the bench, claims and figure.

import { useEffect } from "preact/hooks";
import { isStatic } from "../engine/local.ts";
import { openInBench } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { Claims, Reports } from "./claims.tsx";
import { Cite } from "./cite.tsx";
import { Comparison } from "./comparison.tsx";
import { Figure } from "./figure.tsx";
import { StudyProgress } from "./progress.tsx";
import { begin, open, running, shown, soFar, subject, trouble } from "./state.ts";
import type { Source, StudyPage, Told } from "./types.ts";
import { describeTally } from "./verdict.tsx";
import { Words } from "./words.tsx";

function Sources({ sources }: { sources: Source[] }) {
  return (
    <details class="sources">
      <summary>Sources</summary>
      <ul>
        {sources.map((source) => (
          <li key={source.key}>
            {source.text} {source.link && <a href={source.link} target="_blank" rel="noreferrer">{source.link}</a>}
            {source.note && <span class="soft"> ({source.note})</span>}
          </li>
        ))}
      </ul>
    </details>
  );
}

function Guide({ study }: { study: StudyPage }) {
  return (
    <section class="panel stack guide" aria-label="Guide">
      {study.guide.map((paragraph, k) => (
        <p key={k}>
          <Words text={paragraph} />
        </p>
      ))}
      <Sources sources={study.sources} />
    </section>
  );
}

function Digest({ digest }: { digest: Told[] }) {
  return (
    <section class="panel" aria-label="Digest">
      <dl class="digest">
        {digest.map(({ heading, text }) => (
          <div key={heading}>
            <dt>{heading}</dt>
            <dd>{text}</dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

function Scenarios({ study }: { study: StudyPage }) {
  if (study.scenarios.length === 0) return null;
  return (
    <section class="panel stack" aria-label="Scenarios">
      <h2>On the bench</h2>
      {study.scenarios.map(({ title, text }) => (
        <div key={title} class="row scenario">
          <span>{title}</span>
          <button type="button" onClick={() => openInBench(text)} aria-label={`Open in bench: ${title}`}>
            Open in bench
          </button>
        </div>
      ))}
    </section>
  );
}

/** The origin of the shown results on a page without a server. */
function Stored({ study }: { study: StudyPage }) {
  return (
    <section class="panel stack" aria-label="Computation">
      <p class="small soft">
        Values and figure are part of {study.results?.made_by}. This page has no server; <code>martensite study {study.name} --recompute</code> computes
        them on your machine.
      </p>
    </section>
  );
}

function Compute({ study }: { study: StudyPage }) {
  const results = study.results;
  return (
    <section class="panel stack" aria-label="Computation">
      <h2>Compute</h2>
      <p class="small soft">
        {results?.made_by
          ? `Values and figure are part of ${results.made_by}. A new computation takes seconds to minutes.`
          : results
            ? `Computed in ${results.seconds.toFixed(0)} s; the results are stored.`
            : `${study.parts.length} part${study.parts.length > 1 ? "s" : ""} and a figure: seconds to minutes, the longest for fits and searches.`}
      </p>
      {study.missing.map((set) => (
        <Message key={set.name} kind="caution">
          The data set “{set.title}” is not on this machine; claims that need it cannot be checked. Fetch it with{" "}
          <code>{set.fetch}</code>, then compute.
        </Message>
      ))}
      <StudyProgress name={study.name} />
      {!running.value && (
        <div class="row">
          <button type="button" class={results?.figure ? "" : "main"} onClick={() => void begin(study.name)}>
            {results?.figure ? "Compute again" : "Compute claims and figure"}
          </button>
        </div>
      )}
    </section>
  );
}

export function Study({ name }: { name: string }) {
  useEffect(() => void open(name), [name]);
  const study = shown.value?.name === name ? shown.value : null;
  const busy = running.value && subject.value === name;
  const claims = busy ? soFar.value : study?.results?.claims;
  return (
    <div class="stack studies">
      <p class="small">
        <a href="#/studies">All studies</a>
      </p>
      <h1>{study?.title ?? "Study"}</h1>
      {trouble.value && <Message kind="error">{trouble.value}</Message>}
      {!study && !trouble.value && <p class="starting">Loading …</p>}
      {study && (
        <>
          {study.results && !busy && <p>{describeTally(study.results.tally)}</p>}
          <div class="study-pictures">
            {study.results?.figure && !busy && <Figure name={name} version={study.results.figure} about={study.figure} />}
            {claims && <Comparison claims={claims} />}
          </div>
          {study.results && !busy && study.results.digest.length > 0 && <Digest digest={study.results.digest} />}
          <div class="study-head">
            <Guide study={study} />
            <div class="stack">
              <Scenarios study={study} />
              <Cite study={study} />
              {isStatic() ? <Stored study={study} /> : <Compute study={study} />}
            </div>
          </div>
          {claims && claims.length > 0 && <Claims claims={claims} />}
          {study.results && !busy && <Reports reports={study.results.reports} />}
        </>
      )}
    </div>
  );
}
