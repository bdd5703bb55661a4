// Verdicts: a sign and a word each, and how many claims have them.

import type { Tally, Verdict } from "./types.ts";

export const VERDICTS: [verdict: Verdict, sign: string, about: string][] = [
  ["reproduced", "✓", "the computed number is within the tolerance of the published one"],
  ["not reproduced", "✗", "the computed number is outside of the tolerance"],
  ["calibrated", "≈", "the computed number was chosen to meet the published one; agreement says nothing"],
  ["not checkable", "?", "the source prints no number, or the measured data are not on this machine"],
];

const known = (verdict: Verdict): [Verdict, string, string] => VERDICTS.find(([name]) => name === verdict) ?? [verdict, "", ""];
const style = (verdict: Verdict): string => `verdict ${verdict.replaceAll(" ", "-")}`;

export function VerdictMark({ verdict }: { verdict: Verdict }) {
  const [, sign, about] = known(verdict);
  return (
    <span class={style(verdict)} title={about}>
      <span aria-hidden="true">{sign}</span> {verdict}
    </span>
  );
}

/** The tally as a line. */
export function TallyLine({ tally }: { tally: Tally }) {
  return (
    <span class="tally">
      {VERDICTS.filter(([verdict]) => tally[verdict]).map(([verdict, sign, about]) => (
        <span key={verdict} class={style(verdict)} title={about}>
          <span aria-hidden="true">{sign}</span> {tally[verdict]} {verdict}
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
          <span aria-hidden="true">{sign}</span> {tally[verdict]} {verdict}
        </button>
      ))}
    </div>
  );
}

export function counted(claims: { verdict: Verdict }[]): Tally {
  const tally: Tally = { reproduced: 0, "not reproduced": 0, calibrated: 0, "not checkable": 0 };
  for (const claim of claims) tally[claim.verdict] += 1;
  return tally;
}
