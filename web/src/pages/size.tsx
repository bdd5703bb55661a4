export function Page() {
  return <h1>Size</h1>;
}
