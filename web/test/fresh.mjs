// Whether the bundle that is committed is what the sources give: byte for byte.
import { spawnSync } from "node:child_process";
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";

const kept = process.env.MARTENSITE_STATIC ?? "../src/martensite/app/static";
const made = await mkdtemp(join(tmpdir(), "martensite-bundle-"));
try {
  const { status } = spawnSync(process.execPath, ["build.mjs", made], { stdio: "inherit" });
  const [ours, theirs] = await Promise.all([readdir(made), readdir(kept)]);
  const differing = [];
  for (const name of new Set([...ours, ...theirs])) {
    const same =
      ours.includes(name) &&
      theirs.includes(name) &&
      (await readFile(join(made, name))).equals(await readFile(join(kept, name)));
    if (!same) differing.push(name);
  }
  if (status !== 0 || differing.length > 0) {
    console.error(`The bundle is not the newest (${differing.join(", ")}); run \`npm run build\` in web/.`);
    process.exitCode = 1;
  }
} finally {
  await rm(made, { recursive: true });
}
