// Verdicts: a sign and a word each, and how many claims have them.

import type { Tally, Verdict } from "./types.ts";

export const VERDICTS: [verdict: Verdict, sign: string, about: string][] = [
  ["reproduced", "✓", "the computed value is within the tolerance of the published value"],
  ["disagrees", "✗", "the computed value is outside the tolerance, for an unknown reason"],
  ["misprint", "!", "the printed value is wrong, as other values of the source or the corrected equation show"],
  ["self-contradictory", "↯", "two printed statements cannot both hold"],
  ["not comparable", "?", "another wire or record, or required information is not published"],
  ["recovery", "≈", "the value was chosen or fitted with published values, so agreement is no evidence"],
];

const known = (verdict: Verdict): [Verdict, string, string] => VERDICTS.find(([name]) => name === verdict) ?? [verdict, "", ""];
const style = (verdict: Verdict): string => `verdict ${verdict.replaceAll(" ", "-")}`;

/** Place of a verdict: what was compared stands before what cannot be. */
export const rankVerdict = (verdict: Verdict): number => VERDICTS.findIndex(([name]) => name === verdict);

/** What a tally means, in a sentence. A study without comparable values is no failure: it explains the source. */
export function describeTally(tally: Tally): string {
  const [found, apart] = [tally.reproduced, tally.disagrees];
  const wrong = tally.misprint + tally["self-contradictory"];
  const open = tally["not comparable"] + tally.recovery;
  const said: string[] = [];
  if (found) said.push(`${found} of ${found + apart} comparable printed values ${found + apart === 1 ? "is" : "are"} reproduced.`);
  else if (apart) said.push(`${apart} printed ${apart === 1 ? "value differs" : "values differ"} from the computed ${apart === 1 ? "value" : "values"}.`);
  if (wrong) said.push(`${wrong} ${wrong === 1 ? "error" : "errors"} in print ${wrong === 1 ? "is" : "are"} explained.`);
  if (open) said.push(`${open} ${open === 1 ? "value was" : "values were"} fitted or ${open === 1 ? "comes" : "come"} from another wire, and ${open === 1 ? "gets" : "get"} no verdict.`);
  return said.join(" ");
}

export function VerdictMark({ verdict }: { verdict: Verdict }) {
  const [, sign, about] = known(verdict);
  return (
    <span class={style(verdict)} title={about}>
      <span aria-hidden="true">{sign}</span> {verdict}
    </span>
  );
}

const MANY: Partial<Record<Verdict, string>> = { disagrees: "disagree", misprint: "misprints" };

/** So many with a verdict. */
const countOf = (verdict: Verdict, count: number): string => `${count} ${(count !== 1 && MANY[verdict]) || (verdict === "recovery" ? "recovered" : verdict)}`;

/** The tally as a line. */
export function TallyLine({ tally }: { tally: Tally }) {
  return (
    <span class="tally">
      {VERDICTS.filter(([verdict]) => tally[verdict]).map(([verdict, sign, about]) => (
        <span key={verdict} class={style(verdict)} title={about}>
          <span aria-hidden="true">{sign}</span> {countOf(verdict, tally[verdict])}
        </span>
      ))}
    </span>
  );
}

/** The tally as buttons that filter by verdict. */
export function TallyFilter({ tally, chosen, onChoose }: { tally: Tally; chosen: Verdict | ""; onChoose: (verdict: Verdict | "") => void }) {
  return (
    <div class="row tally" role="group" aria-label="Filter by verdict">
      {VERDICTS.map(([verdict, sign, about]) => (
        <button
          key={verdict}
          type="button"
          class={style(verdict)}
          title={about}
          aria-pressed={chosen === verdict}
          disabled={!tally[verdict]}
          onClick={() => onChoose(chosen === verdict ? "" : verdict)}
        >
          <span aria-hidden="true">{sign}</span> {countOf(verdict, tally[verdict])}
        </button>
      ))}
    </div>
  );
}

export function counted(claims: { verdict: Verdict }[]): Tally {
  const tally = Object.fromEntries(VERDICTS.map(([verdict]) => [verdict, 0])) as Tally;
  for (const claim of claims) tally[claim.verdict] += 1;
  return tally;
}
