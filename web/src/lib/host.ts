// Who answers in the place of a server: the kernel of a notebook in which the page stands.

export interface Host {
  /** A call; a newer one of the same lane goes over one that has not begun. */
  call: (name: string, request: object, lane: string) => Promise<unknown>;
  /** A file that a call has made. */
  file: (key: string) => Promise<Blob>;
  /** A file of the page. */
  asset: (name: string) => Promise<Blob>;
}

export let host: Host | null = null;

export const setHost = (next: Host): void => void (host = next);

/** A file of the page, as text. */
export async function readAsset(name: string): Promise<string> {
  if (host) return (await host.asset(name)).text();
  const found = await fetch(name);
  if (!found.ok) throw new Error(`The page is incomplete: ${name} is missing.`);
  return found.text();
}

/** A worker of the page. */
export async function startWorker(name: string): Promise<Worker> {
  const address = host ? URL.createObjectURL(await host.asset(name)) : new URL(name, document.baseURI);
  return new Worker(address, { type: "module" });
}
