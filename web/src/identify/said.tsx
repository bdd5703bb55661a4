// Sentences of the library: names in backquotes as code, units as people write them.

export function Said({ children }: { children: string }) {
  return <>{children.split("`").map((part, k) => (k % 2 ? <code key={k}>{part}</code> : part.replace(/(?<= )degC\b/g, "°C")))}</>;
}
