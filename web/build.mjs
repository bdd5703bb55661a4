// Bundles the page into app/src/martensite_app/static, which is committed: users need no Node.
//   node build.mjs [FOLDER]     another folder, which the server takes from MARTENSITE_STATIC
import { build } from "esbuild";
import { copyFile, mkdir, readdir, rm } from "node:fs/promises";

const out = process.argv[2] ?? "../app/src/martensite_app/static";

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
await build({
  entryPoints: { bench: "src/main.tsx", engine: "src/engine/worker.ts", gif: "src/scene/gif.worker.ts" },
  outdir: out,
  entryNames: "[name]",
  chunkNames: "[name]-[hash]",
  bundle: true,
  splitting: true,
  format: "esm",
  target: ["es2022", "chrome125", "firefox128", "safari18"],
  minify: true,
  legalComments: "linked",
  jsx: "automatic",
  jsxImportSource: "preact",
  charset: "utf8",
});
for (const name of await readdir("public")) await copyFile(`public/${name}`, `${out}/${name}`);
