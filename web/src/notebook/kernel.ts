// The kernel of a notebook as the host of the page: messages through a port, answered in any order.

import type { Host } from "../lib/host.ts";
import { Refusal } from "../lib/refusal.ts";
import { makeId } from "../lib/identity.ts";

/** What goes to the kernel, and what comes back. */
export type Question = { id: string } & ({ call: string; request: object } | { file: string } | { asset: string });
export interface Reply {
  id: string;
  data: Uint8Array<ArrayBuffer>;
  refused?: string;
  kind?: string;
}

interface Pending {
  begin: () => void;
  drop: () => void;
}

/** @param send hands a question on. */
export class Kernel implements Host {
  private readonly asked = new Map<string, { done: (data: Uint8Array<ArrayBuffer>) => void; failed: (error: Refusal) => void }>();
  private readonly busy = new Set<string>();
  private readonly waiting = new Map<string, Pending>();
  /** All views of a widget hear all answers: each knows its own. */
  private readonly view = makeId().slice(0, 8);
  private count = 0;

  constructor(private readonly send: (question: Question) => void) {}

  /** An answer came. */
  hear({ id, data, refused, kind }: Reply): void {
    const one = this.asked.get(id);
    if (!one) return;
    this.asked.delete(id);
    if (refused) one.failed(new Refusal(refused, kind ?? "failed", 400));
    else one.done(data);
  }

  private ask(what: { call: string; request: object } | { file: string } | { asset: string }): Promise<Uint8Array<ArrayBuffer>> {
    const id = `${this.view}-${++this.count}`;
    return new Promise((done, failed) => {
      this.asked.set(id, { done, failed });
      this.send({ id, ...what });
    });
  }

  private async answered(name: string, request: object): Promise<unknown> {
    return JSON.parse(new TextDecoder().decode(await this.ask({ call: name, request })));
  }

  async call(name: string, request: object, lane: string): Promise<unknown> {
    if (!lane) return this.answered(name, request);
    await this.turn(lane);
    this.busy.add(lane);
    try {
      return await this.answered(name, request);
    } finally {
      this.busy.delete(lane);
      const next = this.waiting.get(lane);
      this.waiting.delete(lane);
      next?.begin();
    }
  }

  /** When the lane is free; a newer call drops what waits. */
  private turn(lane: string): Promise<void> {
    if (!this.busy.has(lane)) return Promise.resolve();
    return new Promise((begin, failed) => {
      this.waiting.get(lane)?.drop();
      this.waiting.set(lane, { begin, drop: () => failed(new Refusal("A newer request came.", "superseded", 409)) });
    });
  }

  file = async (key: string): Promise<Blob> => new Blob([await this.ask({ file: key })]);

  asset = async (name: string): Promise<Blob> =>
    new Blob([await this.ask({ asset: name })], { type: name.endsWith(".js") ? "text/javascript" : "text/html" });
}
