// All panels over time, one below the other, and the keys that move the time cursor.

import { useMemo } from "preact/hooks";
import type { Alarm, Panel, Run } from "../lib/types.ts";
import { toShown } from "../lib/numbers.ts";
import { beside, panelChoice, portsOf, shownColumn, type Beside } from "./drawn.ts";
import { EnergyPanels } from "./energy.tsx";
import { moveTime } from "./keys.ts";
import { liveLook, type Look } from "./palette.ts";
import type { Level, Shade } from "./picture.ts";
import { TimePanel, type Series } from "./timepanel.tsx";

export const isShown = (panel: Panel): boolean => panelChoice.value[panel.key] ?? panel.usual;

/** An estimate has the hat of the field: x̂ beside x. */
const hatted = (name: string, symbol: string): string => (/^(.*\.)?estimated\./.test(name) && symbol.length === 1 ? `${symbol}\u0302` : symbol);

function seriesOf(of: Run, panel: Panel, look: (k: number) => Look): Series[] {
  const ports = Object.keys(panel.ports);
  const drawn = ["", ...portsOf(of)].filter((port) => ports.includes(port));
  const names = drawn.flatMap((port) => (panel.ports[port] ?? []).map((name) => ({ port, name })));
  const several = drawn.filter(Boolean).length > 1;
  return names.map(({ port, name }, k) => {
    const how = of.outputs[name];
    const words = `${how?.long_name ?? name}${port && of.ports.length > 1 ? `, ${port}` : ""}`;
    return {
      symbol: `${hatted(name, how?.symbol ?? name)}${several && port ? `_${port}` : ""}`,
      word: port ? name.slice(name.lastIndexOf(".") + 1) : name,
      name: words,
      unit: how?.display_unit ?? "",
      times: of.times,
      values: shownColumn(of, name),
      look: look(k),
    };
  });
}

/** Curves of a pinned run that has such a panel, in the same unit. */
function pinnedSeries(one: Beside, panel: Panel, live: Series[]): Series[] {
  const same = one.run.traces.find((other) => other.key === panel.key);
  const found = same ? seriesOf(one.run, same, () => one.look) : [];
  return found.filter((other) => other.unit === live[0]?.unit);
}

function alarmsOf(of: Run, panel: Panel, ports: string[]): Alarm[] {
  return of.alarms.filter((alarm) => alarm.panel === panel.key && (!alarm.port || ports.includes(alarm.port)));
}

/** All alarms are shaded in all panels, those about a panel more strongly there. */
function shadesOf(of: Run, own: Alarm[]): Shade[] {
  return of.alarms.flatMap((alarm) =>
    alarm.spans.map(([begin, end]) => ({ begin, end, strong: own.includes(alarm), word: alarm.kind })),
  );
}

function levelsOf(own: Alarm[]): Level[] {
  return own
    .filter((alarm) => alarm.level !== null)
    .map((alarm) => ({ y: toShown(alarm.level ?? 0, alarm.how), word: "limit" }));
}

function Trace({ of, panel, last }: { of: Run; panel: Panel; last: boolean }) {
  const pins = beside.value;
  const ports = portsOf(of);
  const parts = useMemo(() => {
    const own = alarmsOf(of, panel, ports);
    const series = seriesOf(of, panel, liveLook);
    return {
      series,
      beside: pins.flatMap((one) => pinnedSeries(one, panel, series)),
      shades: shadesOf(of, own),
      levels: levelsOf(own),
    };
  }, [of, panel, pins, ports.join()]);
  return <TimePanel title={panel.title} {...parts} includes={panel.includes} last={last} />;
}

export function Traces({ of }: { of: Run }) {
  const panels = of.traces.filter(isShown);
  const about = "Curves over time. Arrow keys move the time cursor, with shift in larger steps.";
  return (
    <div class="traces" role="group" tabIndex={0} aria-label={about} onKeyDown={moveTime}>
      {panels.map((panel, k) => (
        <Trace key={panel.key + (k === panels.length - 1)} of={of} panel={panel} last={k === panels.length - 1} />
      ))}
      <EnergyPanels of={of} />
    </div>
  );
}
