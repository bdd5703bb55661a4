// The project: save the session as a file, open one, begin anew, notes. A file that is dropped anywhere opens.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { sentence } from "../lib/api.ts";
import { Menu } from "../plots/menu.tsx";
import { beginAnew, ENDING, forgetEarlier, listEarlier, notes, openProject, saveProject } from "../state/project.ts";
import { replaceDocument } from "../state/session.ts";
import { Message } from "./message.tsx";

type Earlier = Awaited<ReturnType<typeof listEarlier>>;

const when = (at: number): string => new Date(at).toLocaleString([], { dateStyle: "short", timeStyle: "short" });

/** Whether files are being dragged; their names are told only when they are dropped. */
const brings = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;

/** Open a project that is dropped; no other file takes the place of the page. */
function useDrop(open: (file: File) => Promise<void>, say: (words: string) => void): void {
  useEffect(() => {
    const over = (event: DragEvent): void => void (brings(event) && event.preventDefault());
    const catching = (event: DragEvent): void => {
      const file = event.dataTransfer?.files[0];
      if (!file?.name.endsWith(ENDING)) return;
      event.preventDefault();
      event.stopPropagation();
      void open(file);
    };
    const missed = (event: DragEvent): void => {
      if (!brings(event) || event.defaultPrevented) return;
      event.preventDefault();
      say(`“${event.dataTransfer?.files[0]?.name}” is no project (${ENDING}); scenarios are dropped on the list of scenarios of the Bench, logs on Identify.`);
    };
    addEventListener("dragover", over);
    addEventListener("drop", catching, true);
    addEventListener("drop", missed);
    return () => {
      removeEventListener("dragover", over);
      removeEventListener("drop", catching, true);
      removeEventListener("drop", missed);
    };
  }, []);
}

export function ProjectMenu() {
  const fault = useSignal("");
  const earlier = useSignal<Earlier>([]);
  const chooser = useRef<HTMLInputElement>(null);
  const attempt = async (work: () => Promise<void>): Promise<void> => {
    fault.value = "";
    try {
      await work();
    } catch (error) {
      fault.value = sentence(error);
    }
  };
  const open = (file: File): Promise<void> => attempt(() => openProject(file));
  const list = (): void => void listEarlier().then((found) => (earlier.value = found), () => undefined);
  useDrop(open, (words) => (fault.value = words));
  return (
    <div class="project" onPointerDown={list} onKeyDown={list}>
      <Menu name="Project">
        <div class="stack">
          <button type="button" title="Scenario, pinned runs, fits, sizings, sweeps, notes, in one file" onClick={() => void attempt(saveProject)}>
            Save as a file
          </button>
          <button type="button" title={`A file ${ENDING}; you can also drop it anywhere on the page`} onClick={() => chooser.current?.click()}>
            Open …
          </button>
          <button type="button" title="The present session stays in the list of earlier sessions" onClick={() => void attempt(beginAnew)}>
            Start again
          </button>
          <label class="small">
            Notes
            <textarea rows={4} value={notes.value} onInput={(event) => (notes.value = event.currentTarget.value)} />
          </label>
          {earlier.value.length > 0 && (
            <div class="stack" role="group" aria-label="Earlier sessions">
              <span class="small soft">Earlier sessions on this machine</span>
              {earlier.value.map((one) => (
                <button key={one.at} type="button" class="quiet small" onClick={() => void attempt(() => replaceDocument(one.document))}>
                  {one.title}, {when(one.at)}
                </button>
              ))}
              <button type="button" class="quiet small" onClick={() => void attempt(forgetEarlier).then(list)}>
                Delete all of these
              </button>
            </div>
          )}
          <p class="small soft">The session is stored in this browser as you work.</p>
        </div>
      </Menu>
      <input
        ref={chooser}
        class="hidden"
        type="file"
        accept={ENDING}
        tabIndex={-1}
        aria-label="Project file"
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          if (file) void open(file);
          event.currentTarget.value = "";
        }}
      />
      {fault.value && (
        <div class="project-fault">
          <Message kind="error">{fault.value}</Message>
          <button type="button" class="quiet" aria-label="Close" onClick={() => (fault.value = "")}>
            ✕
          </button>
        </div>
      )}
    </div>
  );
}
