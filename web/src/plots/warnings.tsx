// What the run must warn about: limits that were exceeded, with when; cautions about the document.

import { dropMarks } from "../lib/refusal.ts";
import { digits, toShown, difference } from "../lib/numbers.ts";
import type { Alarm, Run } from "../lib/types.ts";
import { cursor, run } from "../state/run.ts";
import { dangersOf } from "../views/cures.ts";
import { isConcerned } from "../views/results.ts";
import { printed } from "./drawn.ts";

const KINDS: Record<string, string> = {
  temperature: "Too hot",
  stress: "Too much stress",
  strain: "Too much strain",
  slack: "Slack",
  supply: "Supply at its limit",
  rig: "Too much current for the supply",
  supervisor: "Alarm of the supervisor",
};

const jump = (time: number): void => void (cursor.value = time);

/** Worst value and limit, where they have a size. */
function sizes({ kind, worst, limit, how }: Alarm): string {
  if (kind === "slack" || kind === "supervisor") return "";
  const shown = (value: number): string =>
    `${digits(kind === "strain" ? difference(value, how) : toShown(value, how), 4)} ${printed(how.display_unit)}`.trim();
  return `${shown(worst)} against ${shown(limit)}`;
}

function When({ alarm }: { alarm: Alarm }) {
  return (
    <>
      <button type="button" onClick={() => jump(alarm.first)} title="Move the time cursor to the start of the alarm">
        from {digits(alarm.first)} s
      </button>
      {alarm.worst_time !== alarm.first && (
        <button type="button" onClick={() => jump(alarm.worst_time)} title="Move the time cursor to the worst value">
          worst at {digits(alarm.worst_time)} s
        </button>
      )}
    </>
  );
}

export function AlarmItem({ alarm }: { alarm: Alarm }) {
  return (
    <li class="alarm" title={dropMarks(alarm.sentence)}>
      <strong>
        <span aria-hidden="true">▲</span> {KINDS[alarm.kind] ?? alarm.kind}
        {alarm.port && ` (${alarm.port})`}
      </strong>
      <span>
        {sizes(alarm)} for {digits(alarm.duration, 3)} s in all
      </span>
      <When alarm={alarm} />
    </li>
  );
}

/** Sentences about the run that are not about an alarm that is listed; and those of the document that do not concern it. */
function others(now: Run): { near: string[]; far: string[] } {
  const told = new Set(now.alarms.map((alarm) => alarm.sentence));
  const warned = now.warnings.filter((one) => !told.has(one)).map((one) => one.replace(/^Warning: /, ""));
  return { near: warned.filter((one) => isConcerned(now, one)), far: [...warned.filter((one) => !isConcerned(now, one)), ...now.cautions] };
}

/** What is unusual of the document; nothing that happens in this run. */
function Notes({ sentences }: { sentences: string[] }) {
  return (
    <details class="warnings-notes small">
      <summary>
        {sentences.length === 1 ? "1 note" : `${sentences.length} notes`} on this scenario
      </summary>
      <ul>
        {sentences.map((sentence) => (
          <li key={sentence}>{dropMarks(sentence)}</li>
        ))}
      </ul>
    </details>
  );
}

export function Warnings() {
  const now = run.value;
  if (!now) return null;
  const { near, far } = others(now);
  const dangers = dangersOf(now);
  const alarms = now.alarms.filter((alarm) => !dangers.includes(alarm));
  const count = alarms.length + near.length;
  if (!count && !far.length) return null;
  return (
    <section class="warnings" aria-label="Warnings">
      {count > 0 && (<ul>
        {alarms.map((alarm) => (
          <AlarmItem key={`${alarm.kind} ${alarm.column}`} alarm={alarm} />
        ))}
        {near.map((sentence) => (
          <li key={sentence}>
            <span aria-hidden="true">△</span> {dropMarks(sentence)}
          </li>
        ))}
      </ul>)}
      {far.length > 0 && <Notes sentences={far} />}
    </section>
  );
}
