export function Page() {
  return <h1>Sweep</h1>;
}
