// The figure of a study; a click enlarges it.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { save } from "../lib/api.ts";
import { Message } from "../ui/message.tsx";

/** The picture of a file: the server gives files only to be saved, so that it is made here. */
function usePicture(file: string) {
  const picture = useSignal<{ blob: Blob; address: string } | null>(null);
  const failed = useSignal(false);
  useEffect(() => {
    let address = "";
    let left = false;
    const load = async (): Promise<void> => {
      const response = await fetch(`/api/files/${file}`);
      if (!response.ok) throw new Error(response.statusText);
      const blob = new Blob([await response.arrayBuffer()], { type: "image/svg+xml" });
      if (left) return;
      address = URL.createObjectURL(blob);
      picture.value = { blob, address };
    };
    load().catch(() => (failed.value = !left));
    return () => {
      left = true;
      if (address) URL.revokeObjectURL(address);
    };
  }, [file]);
  return { picture: picture.value, failed: failed.value };
}

export function Figure({ name, file, about }: { name: string; file: string; about: string }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const { picture, failed } = usePicture(file);
  const alt = `Figure of the study ${name}: ${about}`;
  const enlarge = (): void => dialog.current?.showModal();
  if (failed) return <Message kind="error">The figure could not be loaded; compute the study again.</Message>;
  if (!picture) return <p class="starting">Loading the figure …</p>;
  return (
    <figure class="panel study-figure" aria-label={alt}>
      <button type="button" class="quiet" title="Enlarge" onClick={enlarge}>
        <img src={picture.address} alt={alt} />
      </button>
      <figcaption class="row">
        <span class="soft">{about}</span>
        <button type="button" onClick={enlarge}>
          Enlarge
        </button>
        <button type="button" onClick={() => save(`${name}.svg`, picture.blob)}>
          Save figure
        </button>
      </figcaption>
      <dialog ref={dialog} class="enlarged" aria-label={`Figure of ${name}, enlarged`}>
        <button type="button" onClick={() => dialog.current?.close()}>
          Close
        </button>
        <img src={picture.address} alt={alt} />
      </dialog>
    </figure>
  );
}
