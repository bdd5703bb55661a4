// The stored figure of a study: small in the list, large on its page; a click enlarges it.

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { call, save } from "../lib/api.ts";
import { Message } from "../ui/message.tsx";

/** The picture of a study, loaded once it comes into view. `version` changes when the study is computed again. */
function usePicture(name: string, version: string, seen: boolean) {
  const picture = useSignal<{ blob: Blob; address: string } | null>(null);
  const failed = useSignal(false);
  useEffect(() => {
    if (!seen) return;
    let address = "";
    let left = false;
    const load = async (): Promise<void> => {
      const { svg } = await call<{ svg: string }>("study_figure", { name });
      if (left) return;
      const blob = new Blob([svg], { type: "image/svg+xml" });
      address = URL.createObjectURL(blob);
      picture.value = { blob, address };
    };
    load().catch(() => (failed.value = !left));
    return () => {
      left = true;
      if (address) URL.revokeObjectURL(address);
    };
  }, [name, version, seen]);
  return { picture: picture.value, failed: failed.value };
}

/** The figure in a list of studies; decoration, because the link beside it names the study. */
export function Thumbnail({ name }: { name: string }) {
  const host = useRef<HTMLDivElement>(null);
  const seen = useSignal(false);
  useEffect(() => {
    const watch = new IntersectionObserver(([entry]) => {
      if (entry?.isIntersecting) seen.value = true;
    });
    if (host.current) watch.observe(host.current);
    return () => watch.disconnect();
  }, []);
  const { picture } = usePicture(name, "", seen.value);
  return (
    <div ref={host} class="study-thumbnail">
      {picture && <img src={picture.address} alt="" />}
    </div>
  );
}

export function Figure({ name, version, about }: { name: string; version: string; about: string }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const { picture, failed } = usePicture(name, version, true);
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
