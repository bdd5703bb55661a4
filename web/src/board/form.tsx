// Which board, what it does, and whether it may.

import { take } from "../lib/api.ts";
import { text as onBench } from "../state/scenario.ts";
import {
  ARM, beginRun, BENCH, board, busy, calibration, document, duration, fetchFirmware, isRunning, kind, known, levels, port, readCalibration, scenario, unusable, word,
} from "./state.ts";
import { Select } from "../ui/select.tsx";

function Board() {
  const there = known.value;
  const emulated = there?.boards?.find((one) => one.name === board.value)?.emulated ?? false;
  return (
    <fieldset class="panel stack">
      <legend>Board</legend>
      <label class="board-field">
        Kind
        <Select value={board.value} onChange={(event) => (board.value = event.currentTarget.value)}>
          {there?.boards?.map((one) => (
            <option key={one.name} value={one.name}>
              {one.title}
            </option>
          ))}
        </Select>
      </label>
      <label class="board-field">
        Port
        <Select value={port.value} onChange={(event) => (port.value = event.currentTarget.value)}>
          <option value={there?.emulator} disabled={!emulated || Boolean(there?.missing)}>
            emulator{!emulated ? " (none for this board)" : there?.missing ? " (tools are missing)" : ""}
          </option>
          {there?.ports?.map((one) => (
            <option key={one.name} value={one.name}>
              {one.name} {one.about !== "n/a" && one.about}
            </option>
          ))}
        </Select>
      </label>
      {unusable.value && <p class="small">{unusable.value}</p>}
      {unusable.value ? null : port.value === there?.emulator ? (
        <p class="small soft">The processor is emulated and its wire simulated: nothing real is heated.</p>
      ) : (
        <Calibration />
      )}
      <Firmware />
    </fieldset>
  );
}

function Calibration() {
  return (
    <label class="board-field">
      Calibration
      <input type="file" accept=".json" onChange={(event) => void readCalibration(event.currentTarget.files?.[0])} />
      <span class="small soft">{calibration.value?.name ?? "calibration.json of a calibrated board; without it, the nominal gains of the wiring list are used."}</span>
    </label>
  );
}

/** The loop that the board holds. */
function Firmware() {
  const write = async (): Promise<void> => {
    const found = await fetchFirmware();
    if (found) take(found.key, found.name);
  };
  return (
    <>
      <label class="board-field">
        Loop of the scenario
        <Select value={scenario.value} onChange={(event) => (scenario.value = event.currentTarget.value)}>
          {onBench.value && <option value={BENCH}>the one on the bench</option>}
          {known.value?.scenarios?.map((one) => (
            <option key={one.name} value={one.name}>
              {one.title}
            </option>
          ))}
        </Select>
      </label>
      <button type="button" title="Flash this firmware to a board at a port; an emulator loads it automatically." disabled={!document.value || busy.value !== ""} onClick={() => void write()}>
        {busy.value || "Download its firmware"}
      </button>
    </>
  );
}

function What() {
  return (
    <fieldset class="panel stack">
      <legend>Run</legend>
      <div class="row">
        {(["loop", "levels"] as const).map((one) => (
          <label key={one} class="row">
            <input type="radio" name="kind" checked={kind.value === one} onChange={() => (kind.value = one)} /> {one === "loop" ? "the loop" : "duty-cycle levels"}
          </label>
        ))}
      </div>
      {kind.value === "loop" ? (
        <label class="board-field">
          Duration [s]
          <input type="text" inputMode="decimal" value={duration.value} placeholder="as in the scenario" onInput={(event) => (duration.value = event.currentTarget.value)} />
        </label>
      ) : (
        <label class="board-field">
          Time:duty cycle, …
          <input type="text" value={levels.value} onInput={(event) => (levels.value = event.currentTarget.value)} />
        </label>
      )}
    </fieldset>
  );
}

function Arming() {
  const typed = word.value.trim();
  const heats = typed === ARM;
  return (
    <fieldset class={`panel stack ${heats ? "board-heats" : ""}`}>
      <legend>Arm</legend>
      <label class="board-field">
        Type {ARM} to heat the wire
        <input type="text" autocomplete="off" spellcheck={false} value={word.value} onInput={(event) => (word.value = event.currentTarget.value)} />
      </label>
      <p class="small soft">
        {typed && !heats ? `“${typed}” is not the word ARM.` : heats ? "The board will be armed, and disarmed when the run ends." : "Without the word this is a dry run: the board reports, and nothing is heated."}
      </p>
      <button type="button" class="main" disabled={isRunning.value || unusable.value !== "" || !document.value || (typed !== "" && !heats)} onClick={() => void beginRun()}>
        {heats ? "Arm and run" : "Dry run"}
      </button>
    </fieldset>
  );
}

export function Form() {
  return (
    <div class="stack board-form">
      <Board />
      <What />
      <Arming />
    </div>
  );
}
