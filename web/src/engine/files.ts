// Files beside a page without a server.

import { Refusal } from "../lib/refusal.ts";

/** What the file server has at an address; refuses what is missing, by a name. */
export async function fetchFile(address: string, name = address): Promise<Response> {
  const response = await fetch(address).catch(() => null);
  if (!response?.ok) throw new Refusal(`The page is incomplete: ${name} is missing.`, "lost", response?.status ?? 0);
  return response;
}

/** A module, compiled while it comes, if the server says what it is. */
export async function fetchModule(address: string): Promise<WebAssembly.Module> {
  const response = await fetchFile(address, address.split("/").at(-1));
  if (response.headers.get("Content-Type") === "application/wasm") return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}
