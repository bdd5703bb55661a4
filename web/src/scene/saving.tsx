// The animation as a file: a picture that moves, a video, or a model.

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { save, sentence } from "../lib/api.ts";
import { palette } from "../lib/theme.ts";
import type { Run } from "../lib/types.ts";
import { Menu } from "../plots/menu.tsx";
import { cursor } from "../state/run.ts";
import { Message } from "../ui/message.tsx";
import { Progress } from "../ui/progress.tsx";
import { begin, end, pause, rate } from "./playing.ts";
import type { Taken } from "./recording.ts";
import type { Reading, Stage } from "./stage.ts";

interface Props {
  run: Run;
  ghost: Run | null;
  whole: boolean;
  read: (time: number) => Reading;
  stage: { current: Stage | null };
}

const FILES: [Taken, string, string][] = [
  ["gif", "Animation, GIF", "The whole run as it is seen now, 640 by 360 pixels"],
  ["video", "Video, MP4 or WebM", "The whole run as it is seen now, 1280 by 720 pixels; takes as long as it plays"],
  ["glb", "Model, GLB", "Parts with their motion, for Blender, slides or a web page; colours are those at the cursor"],
];
/** Longest file [s]. */
const LONGEST = 20;

async function made(kind: Taken, props: Props, told: (share: number) => void, stop: AbortSignal): Promise<Blob> {
  const stage = props.stage.current;
  if (!stage) throw new Error("The 3-D picture is not ready yet.");
  const seconds = Math.min((end.peek() - begin.peek()) / rate(), LONGEST);
  if (kind === "glb") return (await import("./glb.ts")).exportModel(stage, seconds, cursor.peek());
  const { recordGif, recordVideo } = await import("./recording.ts");
  const asked = { ...props, stage, palette: palette.peek(), seconds, told, stop };
  return kind === "gif" ? recordGif(asked) : recordVideo(asked);
}

const ENDS: Record<string, string> = { "image/gif": "gif", "video/mp4": "mp4", "video/webm": "webm", "model/gltf-binary": "glb" };

export function Saving(props: Props) {
  const share = useSignal<number | null>(null);
  const busy = useSignal("");
  const failed = useSignal("");
  const stop = useRef(new AbortController());
  async function make(kind: Taken, name: string): Promise<void> {
    if (busy.value) return;
    pause();
    [busy.value, failed.value, share.value] = [name, "", null];
    stop.current = new AbortController();
    try {
      const blob = await made(kind, props, (value) => (share.value = value), stop.current.signal);
      save(`${props.run.title.replace(/[^\w.() -]+/g, "_").slice(0, 60)}.${ENDS[blob.type] ?? "bin"}`, blob);
    } catch (error) {
      if (!stop.current.signal.aborted) failed.value = sentence(error);
    } finally {
      busy.value = "";
    }
  }
  return (
    <Menu name="Save">
      <div class="stack">
        {FILES.map(([kind, name, about]) => (
          <button key={kind} type="button" title={about} disabled={busy.value !== ""} onClick={() => void make(kind, name)}>
            {name}
          </button>
        ))}
        {busy.value && <Progress share={share.value} label={`Making ${busy.value} …`} onCancel={() => stop.current.abort()} />}
        {failed.value && <Message kind="error">{failed.value}</Message>}
      </div>
    </Menu>
  );
}
