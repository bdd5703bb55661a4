// Header with the names of the pages and the choice of light or dark; the page below it.

import { useSignal, useSignalEffect } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { isOffered, place } from "../state/route.ts";
import { Connection } from "./connection.tsx";
import { ProjectMenu } from "./project.tsx";

const NAMES: [page: string, name: string, about: string][] = [
  ["bench", "Bench", "Simulate an actuator"],
  ["studies", "Studies", "Published results, rebuilt"],
  ["identify", "Identify", "Fit a model to your log"],
  ["size", "Size", "Choose a wire"],
  ["sweep", "Sweep", "Vary what you like"],
  ["board", "Board", "Run the loop on a board"],
];

type Theme = "light" | "dark" | "";

function themeNow(): Theme {
  const kept = localStorage.getItem("martensite-theme");
  return kept === "light" || kept === "dark" ? kept : "";
}

function put(theme: Theme): void {
  if (theme) document.documentElement.dataset["theme"] = theme;
  else delete document.documentElement.dataset["theme"];
  localStorage.setItem("martensite-theme", theme);
  dispatchEvent(new Event("martensite-theme"));
}

put(themeNow());

const isDark = (theme: Theme): boolean =>
  theme ? theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;

function ThemeSwitch() {
  const theme = useSignal<Theme>(themeNow());
  const dark = isDark(theme.value);
  const label = dark ? "Switch to light" : "Switch to dark";
  const flip = (): void => put((theme.value = dark ? "light" : "dark"));
  return (
    <button type="button" class="quiet" aria-label={label} title={label} onClick={flip}>
      {dark ? "☀" : "☾"}
    </button>
  );
}

export function Frame({ children }: { children: ComponentChildren }) {
  const { page } = place.value;
  const open = useSignal(false);
  useSignalEffect(() => void (place.value, (open.value = false)));
  const here = NAMES.find(([name]) => name === page)?.[1] ?? "Start";
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => (event.preventDefault(), document.getElementById("main")?.focus())}>
        Skip to the page
      </a>
      <header class="frame">
        <a class="brand" href="#/start" title="What do you want to know?" aria-current={page === "start" ? "page" : undefined}>
          <img src="icon.svg" alt="" width="22" height="22" /> martensite
        </a>
        <button type="button" class="frame-menu" aria-expanded={open.value} aria-controls="pages" aria-label={`${here}, other pages`} onClick={() => (open.value = !open.value)}>
          {here}
        </button>
        <nav id="pages" aria-label="Pages" class={open.value ? "open" : undefined}>
          {NAMES.filter(([name]) => isOffered(name)).map(([name, title, about]) => (
            <a key={name} href={`#/${name}`} title={about} aria-current={page === name ? "page" : undefined}>
              {title}
            </a>
          ))}
        </nav>
        <ProjectMenu />
        <ThemeSwitch />
      </header>
      <Connection />
      <main id="main" tabIndex={-1}>
        {children}
      </main>
    </>
  );
}
