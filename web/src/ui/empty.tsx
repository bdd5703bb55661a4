// What a page shows before there is anything: a picture of what will come, and a sentence.

import type { ComponentChildren } from "preact";
import { PICTURES } from "../start/pictures.tsx";

export function Empty({ picture, children }: { picture: string; children: ComponentChildren }) {
  const Picture = PICTURES[picture];
  return (
    <div class="empty">
      {Picture && <Picture />}
      <p class="soft">{children}</p>
    </div>
  );
}
