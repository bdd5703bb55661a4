// Share a run: its link, and a picture and a text with its key numbers.

import { useSignal } from "@preact/signals";
import { save, sentence } from "../lib/api.ts";
import { digits, toShown } from "../lib/numbers.ts";
import { palette } from "../lib/theme.ts";
import { copyText } from "../lib/words.ts";
import type { Run } from "../lib/types.ts";
import { printed } from "../plots/drawn.ts";
import { Menu } from "../plots/menu.tsx";
import { shownStage } from "../scene/shown.ts";
import { run } from "../state/run.ts";
import { makeAddress } from "../state/scenario.ts";
import { Message } from "../ui/message.tsx";
import { measures } from "../views/results.ts";
import { HIGH, paintCard, WIDE, writeCard, type Card } from "./card.ts";

export function describeCard(now: Run, note: string): Card {
  const numbers = measures(now).flatMap(({ name, value, how }): [string, string][] =>
    value === null ? [] : [[name, `${digits(toShown(value, how), 3)} ${printed(how.display_unit)}`.trim()]],
  );
  return { title: now.title, about: now.described, numbers, note };
}

async function drawCard(card: Card): Promise<Blob> {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [WIDE, HIGH];
  // the picture in space is there only until the browser shows the next one
  paintCard(canvas.getContext("2d")!, card, shownStage.current?.render().canvas ?? null, palette.peek());
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("The picture could not be made."))), "image/png"));
}

const copy = (text: string): Promise<string> => copyText(text, "Copied.", `The browser does not allow copying: ${text}`);

/** Hand picture, text and link to a program of the device. */
async function send(card: Card): Promise<string> {
  const file = new File([await drawCard(card)], "martensite.png", { type: "image/png" });
  try {
    await navigator.share({ title: card.title, text: writeCard(card, await makeAddress()), files: [file] });
    return "";
  } catch (error) {
    return error instanceof DOMException && error.name === "AbortError" ? "" : sentence(error);
  }
}

const canSend = (): boolean => typeof navigator.canShare === "function" && navigator.canShare({ files: [new File([], "martensite.png", { type: "image/png" })] });

export function Share({ note = "" }: { note?: string }) {
  const said = useSignal("");
  const now = run.value;
  if (!now) return null;
  const doing = (act: (card: Card) => Promise<string>) => async (): Promise<void> => {
    said.value = "";
    said.value = await act(describeCard(now, note)).catch(sentence);
  };
  const keep = async (card: Card): Promise<string> => {
    save("martensite.png", await drawCard(card));
    return "";
  };
  return (
    <Menu name="Share" about="Share this run">
      <div class="stack">
        {canSend() && (
          <button type="button" onClick={doing(send)}>
            Send …
          </button>
        )}
        <button type="button" title="An address that contains this scenario" onClick={doing(async () => copy(await makeAddress()))}>
          Copy link
        </button>
        <button type="button" title="Key numbers and address" onClick={doing(async (card) => copy(writeCard(card, await makeAddress())))}>
          Copy text
        </button>
        <button type="button" title="The mechanism with its key numbers, 1200 by 630 pixels" onClick={doing(keep)}>
          Save picture, PNG
        </button>
        {said.value && <Message kind="note">{said.value}</Message>}
      </div>
    </Menu>
  );
}
