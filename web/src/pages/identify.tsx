export function Page() {
  return <h1>Identify</h1>;
}
