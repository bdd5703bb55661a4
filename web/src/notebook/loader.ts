// Loads the bench into the frame of a notebook. The modules are those of the page: the kernel sends them, and an
// import map gives them addresses.

import "../style/notebook.css";
import { Kernel } from "./kernel.ts";
import type { follow, Told } from "./main.tsx";

/** Modules and styles of the bench, put here when it is bundled. */
declare const FILES: string[];

const PREFIX = "martensite/";
const IMPORTED = /\b(from|import|import\()"\.\//g;

function addStyle(text: string): void {
  const style = document.createElement("style");
  style.textContent = text;
  document.head.prepend(style);
}

function addImportMap(modules: [name: string, text: string][]): void {
  const address = (text: string): string => URL.createObjectURL(new Blob([text.replace(IMPORTED, `$1"${PREFIX}`)], { type: "text/javascript" }));
  const map = document.createElement("script");
  map.type = "importmap";
  map.textContent = JSON.stringify({ imports: Object.fromEntries(modules.map(([name, text]) => [PREFIX + name, address(text)])) });
  document.head.append(map);
}

async function load(port: MessagePort): Promise<void> {
  const told: Told[] = [];
  const kernel = new Kernel((ask) => port.postMessage({ ask }));
  port.onmessage = ({ data }: MessageEvent<Told>) => ("reply" in data ? kernel.hear(data.reply) : void told.push(data));
  const files = await Promise.all(FILES.map(async (name): Promise<[string, string]> => [name, await (await kernel.asset(name)).text()]));
  for (const [name, text] of files) if (name.endsWith(".css")) addStyle(text);
  addImportMap(files.filter(([name]) => name.endsWith(".js")));
  const main = (await import(`${PREFIX}notebook.js`)) as { follow: typeof follow };
  main.follow(port, told);
}

addEventListener("message", ({ data, ports }) => {
  if (data !== "martensite" || !ports[0]) return;
  load(ports[0]).catch((error: unknown) => (document.getElementById("page")!.textContent = `The bench could not be loaded: ${String(error)}`));
});
