// A symbol with its index set below.

export function Symbol({ text }: { text: string }) {
  const [head = "", ...below] = text.split("_");
  return (
    <i class="symbol">
      {head}
      {below.length > 0 && <sub>{below.join("_")}</sub>}
    </i>
  );
}
