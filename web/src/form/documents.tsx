// Which scenario is on the bench: a packaged one, a file, text, a new one; undo, redo, link.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { isStatic } from "../engine/local.ts";
import { call, sentence } from "../lib/api.ts";
import { copyText } from "../lib/words.ts";
import { canRedo, canUndo, makeAddress, redo, text, undo } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { Editor } from "./editor.tsx";
import { textOf } from "./files.ts";
import { groupPackaged, type Packaged } from "./packaged.ts";
import { leave, load } from "./state.ts";
import { Select } from "../ui/select.tsx";

const NEW = "";

/** Whether keys belong to a field in which text is written. */
function writes(target: EventTarget | null): boolean {
  if (target instanceof HTMLTextAreaElement) return true;
  return target instanceof HTMLInputElement && target.type !== "range" && target.type !== "checkbox";
}

function onKey(event: KeyboardEvent): void {
  if (!(event.ctrlKey || event.metaKey) || event.altKey || writes(event.target)) return;
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  leave(key === "y" || event.shiftKey ? redo : undo);
}

async function copyLink(): Promise<string> {
  const link = await makeAddress();
  const done = "The link is copied. It opens this scenario with pinned runs, cursor and view, in a bench on this machine.";
  return copyText(link, done, `The browser does not allow copying; the link is ${link}`);
}

export function Documents() {
  const packaged = useSignal<Packaged[]>([]);
  const fault = useSignal("");
  const said = useSignal("");
  const editing = useSignal(false);
  const over = useSignal(false);
  const chooser = useRef<HTMLInputElement>(null);
  useEffect(() => {
    call<{ scenarios: Packaged[] }>("scenarios").then(
      (found) => (packaged.value = found.scenarios),
      (error: Error) => (fault.value = error.message),
    );
    addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, []);

  const put = async (document: string): Promise<void> => {
    said.value = "";
    fault.value = await load(document);
  };
  const open = async (file: File | undefined): Promise<void> => {
    if (!file) return;
    try {
      await put(await textOf(file));
      if (fault.value) fault.value = `“${file.name}”: ${fault.value}`;
    } catch (error) {
      fault.value = sentence(error);
    }
  };
  const drop = (event: DragEvent): void => {
    event.preventDefault();
    over.value = false;
    void open(event.dataTransfer?.files[0]);
  };
  const chosen = packaged.value.find((one) => one.text === text.value)?.name ?? NEW;
  return (
    <div
      class={`documents panel ${over.value ? "over" : ""}`}
      onDragOver={(event) => (event.preventDefault(), (over.value = true))}
      onDragLeave={() => (over.value = false)}
      onDrop={drop}
    >
      <label class="hidden" for="documents-packaged">
        Scenario
      </label>
      <Select
        id="documents-packaged"
        title={packaged.value.find((one) => one.name === chosen)?.title}
        value={chosen}
        onChange={(event) => void put(packaged.value.find((one) => one.name === event.currentTarget.value)?.text ?? NEW)}
      >
        <option value={NEW} disabled>
          {chosen ? "Packaged scenarios …" : "Your own scenario"}
        </option>
        {groupPackaged(packaged.value).map(([title, scenarios]) => (
          <optgroup key={title} label={title}>
            {scenarios.map((one) => (
              <option key={one.name} value={one.name}>
                {one.title}
              </option>
            ))}
          </optgroup>
        ))}
      </Select>
      <div class="documents-buttons">
        {!isStatic() && (
          <button type="button" title="A wire with a dead weight" onClick={() => void put(NEW)}>
            New
          </button>
        )}
        <button type="button" title="A TOML file; you can also drop it here" onClick={() => chooser.current?.click()}>
          Open …
        </button>
        <button type="button" title="Edit the scenario as text" onClick={() => (editing.value = true)}>
          Text …
        </button>
        <button type="button" title="Copy an address that holds this scenario, pinned runs, cursor and view" onClick={async () => void (said.value = await copyLink())}>
          Link
        </button>
        <button type="button" aria-label="Undo" title="Undo (Ctrl+Z)" disabled={!canUndo.value} onClick={() => leave(undo)}>
          ↶
        </button>
        <button type="button" aria-label="Redo" title="Redo (Ctrl+Y)" disabled={!canRedo.value} onClick={() => leave(redo)}>
          ↷
        </button>
      </div>
      <input
        ref={chooser}
        class="hidden"
        type="file"
        accept=".toml,text/plain"
        tabIndex={-1}
        aria-label="Scenario file"
        onChange={(event) => {
          void open(event.currentTarget.files?.[0]);
          event.currentTarget.value = "";
        }}
      />
      {said.value && <Message kind="note">{said.value}</Message>}
      {fault.value && <Message kind="error">{fault.value}</Message>}
      {editing.value && <Editor onClose={() => (editing.value = false)} />}
    </div>
  );
}
