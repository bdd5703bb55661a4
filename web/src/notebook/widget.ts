// The widget of a notebook, by the interface of anywidget: a frame with the bench, between the frame and the kernel.

import type { Said, Told } from "./main.tsx";
import type { Reply } from "./kernel.ts";

/** The page in the frame, put here when it is bundled. */
declare const PAGE: string;

interface Model {
  get: (name: string) => unknown;
  set: (name: string, value: unknown) => void;
  save_changes: () => void;
  send: (content: unknown) => void;
  on: (event: string, heard: (...given: never[]) => void) => void;
  off: (event: string, heard: (...given: never[]) => void) => void;
}

/** Whether a notebook is dark: by what stands behind the widget, since each says it in its own way. */
function isDark(el: Element): boolean {
  for (let at: Element | null = el; at; at = at.parentElement ?? (at.getRootNode() as ShadowRoot).host ?? null) {
    const [red = 0, green = 0, blue = 0, alpha = 1] = (getComputedStyle(at).backgroundColor.match(/[\d.]+/g) ?? []).map(Number);
    if (alpha > 0.5) return 0.3 * red + 0.6 * green + 0.1 * blue < 110;
  }
  return matchMedia("(prefers-color-scheme: dark)").matches && getComputedStyle(document.documentElement).colorScheme.includes("dark");
}

type Buffer = ArrayBuffer | DataView<ArrayBuffer> | Uint8Array<ArrayBuffer>;

function bytesOf(buffer: Buffer | undefined): Uint8Array<ArrayBuffer> {
  if (!buffer) return new Uint8Array();
  return buffer instanceof ArrayBuffer ? new Uint8Array(buffer) : new Uint8Array(buffer.buffer, buffer.byteOffset, buffer.byteLength).slice();
}

function render({ model, el }: { model: Model; el: HTMLElement }): () => void {
  const frame = document.createElement("iframe");
  let port: MessagePort | null = null;
  const tell = (told: Told): void => port?.postMessage(told);
  const size = (): void => void (frame.style.height = `${Number(model.get("height"))}px`);
  const write = (): void => tell({ text: String(model.get("text")) });
  const look = (): void => tell({ dark: isDark(el) });
  const hear = (reply: Omit<Reply, "data">, buffers: Buffer[] = []): void => tell({ reply: { ...reply, data: bytesOf(buffers[0]) } });

  frame.title = "martensite bench";
  frame.style.cssText = "display: block; width: 100%; border: 1px solid #8886; border-radius: 6px";
  frame.srcdoc = PAGE;
  // a frame that is moved in the document loads anew
  frame.addEventListener("load", () => {
    const channel = new MessageChannel();
    port = channel.port1;
    port.onmessage = ({ data }: MessageEvent<Said>) => {
      if ("ask" in data) return model.send(data.ask);
      model.set("text", data.text);
      model.save_changes();
    };
    frame.contentWindow?.postMessage("martensite", "*", [channel.port2]);
    tell({ text: String(model.get("text")), dark: isDark(el) });
  });
  size();
  model.on("change:text", write);
  model.on("change:height", size);
  model.on("msg:custom", hear);
  const watcher = new MutationObserver(look);
  for (const one of [document.documentElement, document.body]) watcher.observe(one, { attributes: true });
  const query = matchMedia("(prefers-color-scheme: dark)");
  query.addEventListener("change", look);
  el.append(frame);
  return () => {
    watcher.disconnect();
    query.removeEventListener("change", look);
    model.off("change:text", write);
    model.off("change:height", size);
    model.off("msg:custom", hear);
  };
}

export default { render };
