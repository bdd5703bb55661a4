export function Page() {
  return <h1>Studies</h1>;
}
