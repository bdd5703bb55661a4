"""A reader who does anything on any page, reloads when he likes, and knows what must be there.

What he knows is kept here, apart from the page: after every reload, new tab and restart of the server
it must be found on the page again.
"""

import contextlib
import os
import random
import re
import signal
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from app_server import Bench, running
from playwright.sync_api import Browser, BrowserContext, expect

from martensite.app.documents import list_standalone
from martensite.cli.commands.web_bench import pack_text

READY = """() => {
    const { parts } = globalThis.martensiteSession?.() ?? {};
    const busy = document.querySelector("main [aria-busy=true], main .starting");
    const wished = Object.keys(parts?.wished ?? {}).length && location.hash.startsWith("#/bench");
    return parts?.bench?.text && !wished && !busy;
}"""
"""A number that was typed and is not answered yet is kept, and asked for again on the bench."""
FLAT = """(() => {
    const known = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...how) {
        return kind.startsWith("webgl") ? null : known.call(this, kind, ...how);
    };
})()"""
"""Without the picture in space, which takes most of the time of a reload."""
TITLE = "Constant power by PWM, 0.1 mm wire"
TEXT = list_standalone()["constant_power"]


class Walk:
    """The page, the server, and all that the reader has done."""

    def __init__(self, browser: Browser, folder: Path, log: Path, seed: int) -> None:
        self.browser, self.folder, self.log = browser, folder, log
        self.dice = random.Random(seed)
        self.servers = contextlib.ExitStack()
        self.starts = 0
        self.bench = self._start()
        self.context: BrowserContext = browser.new_context(
            viewport={"width": 1280, "height": 800}, reduced_motion="reduce"
        )
        self.context.set_default_timeout(30_000)
        self.context.add_init_script(FLAT)
        self.page = self.context.new_page()
        self.at = "bench"
        self.done: list[str] = []
        # what must be there
        self.lengths, self.undone = ["100"], list[str]()
        self.pins: dict[int, tuple[str, str]] = {}
        self.count = 0
        self.panels: dict[str, bool] = {}
        self.cursor = 0.0
        self.search = ""
        self.size: dict[str, str] = {}
        self.sweep_count = "64"
        self.design = "grid"
        self.file = False
        self.notes = ""
        self.page.goto(f"{self.bench.address}#/bench?scenario={pack_text(TEXT)}")
        self.settle()
        self.page.get_by_role("button", name="All parameters").click()

    # ------------------------------------------------------------ the server

    def _start(self, port: int = 0) -> Bench:
        """A server with a folder of its own, as one without `--folder` has: it knows no files of before."""
        self.starts += 1
        return self.servers.enter_context(running(self.folder / f"server-{self.starts}", port))

    def restart(self) -> None:
        """The server dies and is started again on its port, while the reader goes on."""
        self.settle()
        os.kill(self.bench.pid, signal.SIGKILL)
        if self.at == "bench":
            self.type_length(dying=True)
        self.bench = self._start(self.bench.port)

    # ------------------------------------------------------------ what the reader does

    def settle(self) -> None:
        self.page.wait_for_function(READY)

    def go(self) -> None:
        """Another page of the bench."""
        self.at = self.dice.choice(["bench", "bench", "size", "identify", "sweep", "studies"])
        self.page.get_by_role("link", name=self.at.capitalize(), exact=True).click()

    def reload(self) -> None:
        """At once, whatever is on its way."""
        self.page.reload()

    def reopen(self) -> None:
        """A new tab, which begins with the last one, in place of it."""
        self.page.wait_for_timeout(400)  # what a tab keeps is seen by others a moment later
        page = self.context.new_page()
        page.goto(self.bench.origin)
        self.page.close()
        self.page = page

    def open_cut_link(self) -> None:
        """A link without its end, in another tab: it says so and changes nothing."""
        if self.at != "bench":
            return
        self.settle()
        self.page.wait_for_timeout(800)
        page = self.context.new_page()
        page.goto(cut := self.page.url[:-40])
        expect(page.get_by_text("This link is damaged")).to_be_visible()
        assert page.url == cut
        expect(page.get_by_role("button", name="Open what was here last")).to_be_visible()
        page.close()

    def type_length(self, dying: bool = False) -> None:
        value = str(self.dice.randint(20, 400))
        field = self.page.locator("#form-element-length")
        if value == self.lengths[-1] or not self.on_bench():
            return
        if not dying:
            self.settle()  # of two that are typed at once the first is no step to undo
        field.fill(value)
        field.press("Enter")
        self.lengths.append(value)
        self.undone.clear()

    def on_bench(self) -> bool:
        if self.at != "bench" or self.search:
            return False
        expect(self.page.locator("#form-element-length")).to_be_visible()
        return True

    def undo(self) -> None:
        if len(self.lengths) > 1 and self.on_bench():
            self.settle()
            self.page.get_by_role("button", name="Undo").click()
            self.undone.append(self.lengths.pop())

    def redo(self) -> None:
        if self.undone and self.on_bench():
            self.settle()
            self.page.get_by_role("button", name="Redo").click()
            self.lengths.append(self.undone.pop())

    def pin(self) -> None:
        if len(self.pins) < 3 and self.on_bench():
            self.settle()
            self.page.get_by_role("button", name="Pin this run").click()
            self.count += 1
            self.pins[self.count] = (f"{self.count}: {TITLE}", self.lengths[-1])

    def rename(self) -> None:
        if self.pins and self.at == "bench":
            which = self.dice.choice(sorted(self.pins))
            name = f"mine {self.dice.randint(0, 999)}"
            field = self.page.get_by_label(f"Name of pinned run {which}")
            expect(field).to_be_visible()
            field.fill(name)
            field.press("Tab")
            self.pins[which] = (name, self.pins[which][1])

    def unpin(self) -> None:
        if self.pins and self.at == "bench":
            which = self.dice.choice(sorted(self.pins))
            self.page.get_by_role("button", name=f"Unpin {self.pins.pop(which)[0]}").click()

    def move(self) -> None:
        """The time cursor."""
        if self.on_bench():
            self.settle()
            slider = self.page.get_by_role("slider", name="Time", exact=True)
            slider.press("ArrowRight")
            self.cursor = self.page.evaluate("martensiteSession().parts.runs.cursor")
            assert self.cursor > 0

    def choose_panel(self) -> None:
        if self.at == "bench":
            self.settle()
            self.page.locator(".charts-bar summary", has_text="Curves").click()
            box = self.page.get_by_role("checkbox", name="energy")
            box.click()
            self.panels["energy"] = box.is_checked()
            self.page.keyboard.press("Escape")

    def find(self) -> None:
        if self.at == "bench":
            self.search = "" if self.search else "power"
            self.page.get_by_label("Find a parameter").fill(self.search)

    def fill_size(self) -> None:
        if self.at == "size":
            name = self.dice.choice(["force", "stroke"])
            self.size[name] = f"{self.dice.randint(1, 9)} {'N' if name == 'force' else 'mm'}"
            self.page.locator(f"#size-{name}").fill(self.size[name])

    def set_sweep(self) -> None:
        if self.at == "sweep":
            field = self.page.locator("#sweep-design")
            expect(field.locator("option").first).to_be_attached()
            self.design, self.sweep_count = "sobol", str(2 ** self.dice.randint(3, 9))
            field.select_option(self.design)
            self.page.locator("#sweep-count").fill(self.sweep_count)

    def take_file(self) -> None:
        if self.at == "identify" and not self.file:
            self.page.get_by_label(re.compile("^Drop (a log|logs) here")).set_input_files(str(self.log))
            expect(self.page.get_by_role("heading", level=2)).to_contain_text(self.log.name)
            self.file = True

    def note(self) -> None:
        self.notes = f"note {self.dice.randint(0, 9999)}"
        summary = self.page.locator(".project summary")
        summary.click()
        self.page.get_by_label("Notes").fill(self.notes)
        self.page.keyboard.press("Escape")

    # ------------------------------------------------------------ what must be there

    def check(self) -> None:
        """All that is on the page, and all that is kept of others."""
        self.settle()
        parts: dict[str, Any] = self.page.evaluate("martensiteSession().parts")
        self._check_bench(parts)
        assert {name: text for name, text in parts.get("size", {}).get("fields", {}).items() if text} == self.size
        choices = parts.get("sweep", {}).get("choices", {"design": "grid", "count": "64"})
        assert (choices["design"], choices["count"]) == (self.design, self.sweep_count)
        assert parts.get("notes", {}).get("notes", "") == self.notes
        file = parts.get("identify", {}).get("state", {}).get("file")
        assert (file["name"] if file else None) == (self.log.name if self.file else None)
        assert self.page.evaluate("location.hash").startswith(f"#/{self.at}")
        getattr(self, f"_see_{self.at}")()

    def _check_bench(self, parts: dict[str, Any]) -> None:
        bench, runs = parts["bench"], parts.get("runs", {"pins": [], "cursor": 0.0})
        found = [length_of(text) for text in (*bench["before"], bench["text"])]
        found += [float(text.split()[0]) for text in parts.get("wished", {}).values()]
        wanted = [float(x) for x in self.lengths]
        assert found == wanted, f"lengths {found} instead of {wanted}"
        assert [length_of(text) for text in bench["after"]] == [float(x) for x in self.undone]
        pins = {one["id"]: (one["name"], length_of(one["text"])) for one in runs["pins"]}
        assert pins == {which: (name, float(length)) for which, (name, length) in self.pins.items()}
        assert runs["cursor"] == self.cursor
        assert parts.get("view", {}).get("panels", {}) == self.panels
        assert parts.get("form", {}).get("search", "") == self.search

    def _see_bench(self) -> None:
        expect(self.page.get_by_label("Find a parameter")).to_have_value(self.search)
        if not self.search:
            expect(self.page.locator("#form-element-length")).to_have_value(self.lengths[-1])
        expect(self.page.locator(".pin-name")).to_have_count(len(self.pins))
        for which, (name, _) in self.pins.items():
            expect(self.page.get_by_label(f"Name of pinned run {which}")).to_have_value(name)
        for name, shown in self.panels.items():
            expect(self.page.get_by_role("figure", name=name, exact=True)).to_have_count(int(shown))

    def _see_size(self) -> None:
        for name, text in self.size.items():
            expect(self.page.locator(f"#size-{name}")).to_have_value(text)

    def _see_sweep(self) -> None:
        expect(self.page.locator("#sweep-design")).to_have_value(self.design)
        if self.design != "grid":
            expect(self.page.locator("#sweep-count")).to_have_value(self.sweep_count)

    def _see_identify(self) -> None:
        if self.file:
            expect(self.page.get_by_role("heading", level=2)).to_contain_text(self.log.name)

    def _see_studies(self) -> None:
        expect(self.page.get_by_role("heading", level=1)).to_be_visible()

    def walk(self, count: int, restarts: int) -> None:
        """Random actions; the server dies at some of them."""
        anywhere = [self.go] * 3 + [self.reload] * 3 + [self.note, self.reopen]
        there = {
            "bench": [self.type_length] * 3
            + [self.undo, self.redo, self.pin, self.rename, self.unpin, self.move, self.choose_panel, self.find]
            + [self.open_cut_link],
            "size": [self.fill_size] * 3,
            "sweep": [self.set_sweep] * 3,
            "identify": [self.take_file] * 3,
            "studies": [],
        }
        dying = {round((k + 1) * count / (restarts + 1)) for k in range(restarts)}
        for step in range(count):
            action = self.restart if step in dying else self.dice.choice(anywhere + there[self.at])
            self.done.append(f"{step} {action.__name__} on {self.at}")
            action()
            if action in (self.reload, self.reopen, self.restart):
                self.check()
        self.reload()
        self.check()
        for self.at in ("bench", "size", "identify", "sweep"):
            self.page.goto(f"{self.bench.origin}/#/{self.at}")
            self.check()


def length_of(text: str) -> float:
    """Length of the wire of a scenario [mm]."""
    value, unit = tomllib.loads(text)["element"]["length"].split()
    return round(float(value) * {"mm": 1.0, "m": 1000.0, "cm": 10.0}[unit], 6)


@contextlib.contextmanager
def walking(browser: Browser, folder: Path, log: Path, seed: int) -> Iterator[Walk]:
    """A walk, whose servers end with it; a failure tells what was done before."""
    walk = Walk(browser, folder, log, seed)
    try:
        yield walk
    except BaseException as error:
        error.add_note("\n".join(walk.done[-25:]))
        raise
    finally:
        walk.context.close()
        with contextlib.suppress(ProcessLookupError):
            walk.servers.close()
