// The page: a frame with the names of the pages, and the page that the address names.

import "./style/all.css";
import { useSignal, useSignalEffect } from "@preact/signals";
import { render, type ComponentType } from "preact";
import { place } from "./state/route.ts";
import { Frame } from "./ui/frame.tsx";
import { Message } from "./ui/message.tsx";

type Loaded = { Page: ComponentType };

/** Each page is loaded when it is first opened. */
const PAGES: Record<string, () => Promise<Loaded>> = {
  bench: () => import("./pages/bench.tsx"),
  studies: () => import("./pages/studies.tsx"),
  identify: () => import("./pages/identify.tsx"),
  size: () => import("./pages/size.tsx"),
  sweep: () => import("./pages/sweep.tsx"),
  board: () => import("./pages/board.tsx"),
};

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
    if (shown.peek()?.name === name) return;
    load().then(
      ({ Page }) => {
        if (place.peek().page === name) shown.value = { name, Page };
      },
      () => (failed.value = "This page could not be loaded; is `martensite app` still running?"),
    );
  });
  if (failed.value) return <Message kind="error">{failed.value}</Message>;
  const now = shown.value;
  return now ? <now.Page key={now.name} /> : <p class="starting">Loading …</p>;
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
  root.textContent = "";
  render(<App />, root);
}
