// The page of a report: one file with a run in it, drawn as on the bench, that asks nobody for anything.

import "../style/report.css";
import { useSignal } from "@preact/signals";
import { render } from "preact";
import type { FormNode, GroupNode, NumberNode } from "../form/types.ts";
import { save } from "../lib/api.ts";
import { digits, toShown } from "../lib/numbers.ts";
import { unpacked } from "../lib/pack.ts";
import { Panels, Ports, WholeTime } from "../plots/chooser.tsx";
import { printed } from "../plots/drawn.ts";
import { Key, Loops } from "../plots/loops.tsx";
import { Phase } from "../plots/phase.tsx";
import { pointed } from "../plots/pointing.ts";
import { Traces } from "../plots/traces.tsx";
import { Warnings } from "../plots/warnings.tsx";
import { liveLook, pinLook } from "../plots/palette.ts";
import { Swatch } from "../plots/swatch.tsx";
import { copyText } from "../lib/words.ts";
import { pinned, run } from "../state/run.ts";
import { writePart } from "../state/session.ts";
import { Message } from "../ui/message.tsx";
import { Table } from "../ui/table.tsx";
import type { ReportData } from "./data.ts";

/** The results in large, and beside them those of pinned runs. */
function Results({ data }: { data: ReportData }) {
  const beside = data.pins.map((pin) => new Map(pin.run.key));
  return (
    <dl class="report-results">
      {data.run.key.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>
            {value}
            {beside.map((known, k) => (
              <small key={k}>
                <Swatch look={pinLook(data.pins[k]?.id ?? 1)} /> {known.get(name) ?? "–"}
              </small>
            ))}
          </dd>
        </div>
      ))}
    </dl>
  );
}

function Runs({ data }: { data: ReportData }) {
  if (!data.pins.length) return null;
  return (
    <ul class="report-runs small">
      <li>
        <Swatch look={liveLook(0)} /> this run
      </li>
      {data.pins.map((pin) => (
        <li key={pin.id}>
          <Swatch look={pinLook(pin.id)} /> {pin.name}
        </li>
      ))}
    </ul>
  );
}

/** Of the phase diagram [px]. */
const HEIGHT = 230;

function Charts({ data: { run: of } }: { data: ReportData }) {
  return (
    <section class="charts panel" aria-label="Charts">
      <div class="charts-bar row">
        <h2>Charts</h2>
        <Ports of={of} />
        <Panels of={of} />
        <WholeTime />
        <p class="soft small hint">Point: values. Drag: zoom. Double click: all.</p>
      </div>
      <div class="charts-columns">
        <Traces of={of} />
        {of.ports.length > 0 && (
          <div class="loops">
            <Key of={of} />
            <Loops of={of} isBeside />
            <Phase of={of} height={HEIGHT} />
            <Loops of={of} isBeside={false} />
          </div>
        )}
      </div>
    </section>
  );
}

const numbersOf = (nodes: FormNode[]): NumberNode[] =>
  nodes.flatMap((node) => (node.sort === "group" ? numbersOf(node.items) : node.sort === "number" && node.value !== null ? [node] : []));

const about = ({ origin }: NumberNode): string => [origin.words, origin.source, origin.where, origin.note].filter(Boolean).join("; ");

/** Every number that was used, and where it is from. */
function Sources({ sections }: { sections: GroupNode[] }) {
  const parts = sections.map((section) => ({ title: section.title, numbers: numbersOf(section.items) })).filter((part) => part.numbers.length);
  return (
    <section class="stack" aria-label="Numbers and their sources">
      <h2>Numbers and their sources</h2>
      {parts.map(({ title, numbers }) => (
        <details key={title}>
          <summary>
            {title} <span class="soft small">{numbers.length} numbers</span>
          </summary>
          <Table
            caption={title}
            headings={["number", "value", "source"]}
            rows={numbers.map((one) => [
              <span title={one.meaning}>{one.title}</span>,
              `${digits(toShown(one.value ?? 0, one), 6)} ${printed(one.display_unit)}`,
              about(one),
            ])}
            right={[1]}
          />
        </details>
      ))}
    </section>
  );
}

function Differences({ data }: { data: ReportData }) {
  if (!data.differences.length) return null;
  const rows = data.differences.map((row) => [row.path, ...row.values.map((value) => value ?? "–")]);
  return <Table caption="What differs" headings={["entry", "this run", ...data.pins.map((pin) => pin.name)]} rows={rows} />;
}

function Scenario({ text, title }: { text: string; title: string }) {
  const said = useSignal("");
  const copy = async (): Promise<void> => {
    said.value = await copyText(text, "Copied.", "The browser does not allow copying; choose the text below.");
  };
  return (
    <section class="stack" aria-label="Scenario">
      <h2>Scenario</h2>
      <div class="row">
        <button type="button" onClick={copy}>
          Copy
        </button>
        <button type="button" onClick={() => save(`${title.replace(/[^\w.() -]+/g, "_").slice(0, 60)}.toml`, text)}>
          Save as a file
        </button>
        <span class="soft small" role="status">
          {said.value || "“martensite run” and the bench take it."}
        </span>
      </div>
      <pre class="report-text" tabIndex={0} aria-label="Scenario, TOML">
        {text}
      </pre>
    </section>
  );
}

function Report({ data }: { data: ReportData }) {
  const { run: of, notes, made } = data;
  return (
    <main class="report stack">
      <header>
        <h1>{of.title}</h1>
        <p class="soft">{of.described}</p>
      </header>
      {notes && <p class="report-notes">{notes}</p>}
      <Results data={data} />
      {data.insight && <p class="report-insight panel">{data.insight}</p>}
      <Runs data={data} />
      <Warnings />
      <Charts data={data} />
      <Differences data={data} />
      <Sources sections={data.sections} />
      <Scenario text={of.text} title={of.title} />
      <footer class="soft small">
        {made}; {of.samples} samples, {of.steps} steps. This file loads nothing and tells nobody.
      </footer>
    </main>
  );
}

const root = document.getElementById("page");
const letters = document.getElementById("report-data")?.textContent?.trim() ?? "";

async function begin(home: HTMLElement): Promise<void> {
  try {
    const data = JSON.parse(await unpacked(letters, "deflate")) as ReportData;
    document.title = data.run.title;
    run.value = data.run;
    pinned.value = data.pins;
    for (const [name, part] of Object.entries(data.parts)) writePart(name, part);
    pointed.value = true;
    home.textContent = "";
    render(<Report data={data} />, home);
  } catch {
    home.textContent = "";
    render(<Message kind="error">The data in this file cannot be read; it may be cut.</Message>, home);
  }
}

if (root) void begin(root);
