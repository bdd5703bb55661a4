// The page: a frame with the names of the pages, and the page that the address names.

import "./style/all.css";
import { useSignal, useSignalEffect } from "@preact/signals";
import { Component, render, type ComponentChildren, type ComponentType } from "preact";
import { SERVER } from "./engine/inputs.ts";
import { expectFirst, isStatic } from "./engine/local.ts";
import { awaitServer } from "./lib/connection.ts";
import { isOffered, place } from "./state/route.ts";
import { openSession } from "./state/session.ts";
import { Frame } from "./ui/frame.tsx";
import { Message } from "./ui/message.tsx";

type Loaded = { Page: ComponentType };

/** Each page is loaded when it is first opened. */
const PAGES: Record<string, () => Promise<Loaded>> = {
  start: () => import("./pages/start.tsx"),
  bench: () => import("./pages/bench.tsx"),
  studies: () => import("./pages/studies.tsx"),
  identify: () => import("./pages/identify.tsx"),
  size: () => import("./pages/size.tsx"),
  sweep: () => import("./pages/sweep.tsx"),
  board: () => import("./pages/board.tsx"),
};

const RELOADED = "martensite-reloaded";

/** Load the page anew, as browsers remember what could not be loaded; not again and again. */
function reloadOnce(): void {
  const last = Number(sessionStorage.getItem(RELOADED) ?? 0);
  if (Date.now() - last < 30_000) return;
  sessionStorage.setItem(RELOADED, String(Date.now()));
  location.reload();
}

/** Says so when a page cannot be drawn, as with a project that somebody has written by hand. */
class Guarded extends Component<{ children: ComponentChildren }, { fault: string }> {
  override state = { fault: "" };

  static getDerivedStateFromError(error: unknown): { fault: string } {
    return { fault: String(error) };
  }

  render(): ComponentChildren {
    const { fault } = this.state;
    if (!fault) return this.props.children;
    return <Message kind="error">This page cannot be drawn from what is kept: {fault}. “Project, Start again” leaves that behind.</Message>;
  }
}

function Current() {
  const shown = useSignal<{ name: string; Page: ComponentType } | null>(null);
  const failed = useSignal("");
  useSignalEffect(() => {
    const name = place.value.page;
    const load = PAGES[name];
    failed.value = "";
    if (!load) {
      failed.value = `There is no page “${name}”. There are: ${Object.keys(PAGES).join(", ")}.`;
      return;
    }
    if (!isOffered(name)) {
      failed.value = `The page “${name}” needs a server. ${SERVER}`;
      return;
    }
    if (shown.peek()?.name === name) return;
    load().then(
      ({ Page }) => {
        if (place.peek().page === name) shown.value = { name, Page };
      },
      () => {
        failed.value = "This page could not be loaded. Start “martensite app” again.";
        void awaitServer().then(reloadOnce);
      },
    );
  });
  if (failed.value) return <Message kind="error">{failed.value}</Message>;
  const now = shown.value;
  return now ? <Guarded key={now.name}><now.Page /></Guarded> : <p class="starting">Loading …</p>;
}

function App() {
  return (
    <Frame>
      <Current />
    </Frame>
  );
}

const root = document.getElementById("page");
if (root) {
  // what is needed next comes while the session is read; what fails is said when it is asked for
  void PAGES[place.peek().page]?.().catch(() => undefined);
  if (isStatic() && ["bench", "start"].includes(place.peek().page)) void expectFirst().catch(() => undefined);
  void openSession().finally(() => {
    root.textContent = "";
    render(<App />, root);
  });
}
