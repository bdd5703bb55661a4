// Text with names between backticks.

export function Words({ text }: { text: string }) {
  return <>{text.split("`").map((piece, k) => (k % 2 ? <code key={k}>{piece}</code> : piece))}</>;
}
