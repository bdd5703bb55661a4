// A choice whose text breaks into lines where it is long: browsers cut it.

import { useSignal } from "@preact/signals";
import type { JSX } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";

export function Select(props: JSX.IntrinsicElements["select"]) {
  const own = useRef<HTMLSelectElement>(null);
  const shown = useSignal("");
  useLayoutEffect(() => void (shown.value = own.current?.selectedOptions[0]?.text ?? ""));
  return (
    <span class="select">
      <span aria-hidden="true">{shown.value}</span>
      <select {...props} ref={own} />
    </span>
  );
}
