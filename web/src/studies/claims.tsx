// The claims of a study: published against computed, with filter and order.

import { useSignal } from "@preact/signals";
import { digits } from "../lib/numbers.ts";
import { printed } from "../plots/drawn.ts";
import type { Claim, Report, Verdict } from "./types.ts";
import { counted, describeTally, rankVerdict, TallyFilter, VerdictMark } from "./verdict.tsx";

type Key = (claim: Claim) => string | number;
type Order = { column: number; down: boolean } | null;

const number = (value: number | null): number => value ?? Infinity;
const COLUMNS: [heading: string, key: Key | null, right?: boolean][] = [
  ["Claim", (claim) => claim.id],
  ["Published", (claim) => number(claim.published), true],
  ["Computed", (claim) => number(claim.computed), true],
  ["Tolerance", (claim) => number(claim.tolerance), true],
  ["Unit", (claim) => claim.unit],
  ["Verdict", (claim) => claim.verdict],
  ["Why", null],
  ["Source", (claim) => claim.source],
];

function compared(key: Key, down: boolean): (a: Claim, b: Claim) => number {
  const sign = down ? -1 : 1;
  return (a, b) => {
    const [p, q] = [key(a), key(b)];
    if (p === q) return 0;
    if (p === Infinity || q === Infinity) return p === Infinity ? 1 : -1; // those without a number last
    return (p < q ? -1 : 1) * sign;
  };
}

const matches = (claim: Claim, words: string): boolean =>
  [claim.id, claim.statement, reason(claim), claim.source, claim.unit].join(" ").toLowerCase().includes(words.toLowerCase());

const unit = (name: string): string => (name === "1" ? "" : printed(name));

function Heading({ column, order, onOrder }: { column: number; order: Order; onOrder: (order: Order) => void }) {
  const [heading, key, right] = COLUMNS[column] ?? ["", null];
  const mine = order?.column === column ? order : null;
  const sorted = mine ? (mine.down ? "descending" : "ascending") : undefined;
  const next: Order = !mine ? { column, down: false } : mine.down ? null : { column, down: true };
  return (
    <th scope="col" class={right ? "right" : undefined} aria-sort={sorted}>
      {key ? (
        <button type="button" class="quiet" title="Sort" onClick={() => onOrder(next)}>
          {heading} <span aria-hidden="true">{mine ? (mine.down ? "▾" : "▴") : "↕"}</span>
        </button>
      ) : (
        heading
      )}
    </th>
  );
}

/** What a misprinted equation gives stands in brackets, as it is printed nowhere. */
const published = (claim: Claim): string => (claim.as_printed === null ? digits(claim.published) : `(${digits(claim.as_printed)})`);

const GROUNDS = ["correction", "against", "differs"] as const;
const reason = (claim: Claim): string =>
  [...GROUNDS.filter((name) => claim[name]).map((name) => `${name}: ${claim[name]}`), claim.why].join("; ");

function Row({ claim }: { claim: Claim }) {
  return (
    <tr>
      <th scope="row">
        <span>{claim.statement}</span>
        <code>{claim.id}</code>
      </th>
      <td class="right">{published(claim)}</td>
      <td class="right">{digits(claim.computed)}</td>
      <td class="right" title={claim.tolerance_reason || undefined}>
        {claim.tolerance === null ? "–" : `± ${digits(claim.tolerance)}`}
      </td>
      <td>{unit(claim.unit)}</td>
      <td>
        <VerdictMark verdict={claim.verdict} />
      </td>
      <td class="small why">{reason(claim)}</td>
      <td class="small soft">{claim.source}</td>
    </tr>
  );
}

export function Claims({ claims }: { claims: Claim[] }) {
  const verdict = useSignal<Verdict | "">("");
  const words = useSignal("");
  const order = useSignal<Order>(null);
  const rows = claims.filter((claim) => (!verdict.value || claim.verdict === verdict.value) && matches(claim, words.value));
  const key = order.value && COLUMNS[order.value.column]?.[1];
  rows.sort(key && order.value ? compared(key, order.value.down) : (a, b) => rankVerdict(a.verdict) - rankVerdict(b.verdict));
  const count = rows.length === claims.length ? `${claims.length} claims` : `${rows.length} of ${claims.length} claims`;
  return (
    <section class="panel stack claims" aria-label="Claims">
      <p>{describeTally(counted(claims))}</p>
      <div class="row">
        <TallyFilter tally={counted(claims)} chosen={verdict.value} onChoose={(next) => (verdict.value = next)} />
        <label class="row find">
          Find
          <input type="search" value={words.value} placeholder="words in a claim" onInput={(event) => (words.value = event.currentTarget.value)} />
        </label>
        <span class="soft" role="status">
          {count}
        </span>
      </div>
      <div class="scrolling" tabIndex={0} role="region" aria-label="Table of claims">
        <table>
          <caption>Published and computed values</caption>
          <thead>
            <tr>
              {COLUMNS.map(([heading], column) => (
                <Heading key={heading} column={column} order={order.value} onOrder={(next) => (order.value = next)} />
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.map((claim) => (
              <Row key={claim.id} claim={claim} />
            ))}
          </tbody>
        </table>
      </div>
      {rows.length === 0 && <p class="soft">No claim matches these words and this verdict.</p>}
    </section>
  );
}

/** Numbers of ours, which no source prints: apart from the claims, and without a verdict. */
export function Reports({ reports }: { reports: Report[] }) {
  if (reports.length === 0) return null;
  return (
    <details class="panel claims">
      <summary>
        {reports.length} report{reports.length > 1 ? "s" : ""}: computed here, printed nowhere
      </summary>
      <div class="scrolling" tabIndex={0} role="region" aria-label="Table of reports">
        <table>
          <thead>
            <tr>
              {["Number", "Computed", "Unit", "Why"].map((heading) => (
                <th key={heading} scope="col">
                  {heading}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {reports.map((report) => (
              <tr key={report.id}>
                <th scope="row">
                  <span>{report.statement}</span>
                  <code>{report.id}</code>
                </th>
                <td class="right">{digits(report.computed)}</td>
                <td>{unit(report.unit)}</td>
                <td class="small why">{report.why}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}
