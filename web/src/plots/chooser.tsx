// What the charts show: which port, which panels.

import type { Run } from "../lib/types.ts";
import { ENERGY, energyShown } from "./energy.tsx";
import { panelChoice, portChoice, portsOf, zoom } from "./drawn.ts";
import { Menu } from "./menu.tsx";
import { isShown } from "./traces.tsx";

export function Ports({ of }: { of: Run }) {
  if (of.ports.length < 2) return null;
  const drawn = portsOf(of);
  const now = drawn.length > 1 ? "" : drawn[0];
  return (
    <label class="row">
      Actuator
      <select aria-label="Actuator" value={now} onChange={(event) => (portChoice.value = event.currentTarget.value)}>
        <option value="">all {of.ports.length}</option>
        {of.ports.map((port) => (
          <option key={port} value={port}>
            {port}
          </option>
        ))}
      </select>
    </label>
  );
}

function Choice({ name, title, on }: { name: string; title: string; on: boolean }) {
  const flip = (): void => void (panelChoice.value = { ...panelChoice.value, [name]: !on });
  return (
    <label>
      <input type="checkbox" checked={on} onChange={flip} /> {title}
    </label>
  );
}

export function Panels({ of }: { of: Run }) {
  return (
    <Menu name="Curves">
      <fieldset>
        <legend>Curves over time</legend>
        {of.traces.map((panel) => (
          <Choice key={panel.key} name={panel.key} title={panel.title} on={isShown(panel)} />
        ))}
        <Choice name={ENERGY} title="energy" on={energyShown()} />
      </fieldset>
    </Menu>
  );
}

export function WholeTime() {
  if (!zoom.value) return null;
  return (
    <button type="button" onClick={() => (zoom.value = null)}>
      Show all of the time
    </button>
  );
}
