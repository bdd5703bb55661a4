// Bundles the page into src/martensite/app/static, which is committed: users need no Node.
//   node build.mjs [FOLDER]     another folder, which the server takes from MARTENSITE_STATIC
import { build } from "esbuild";
import { copyFile, mkdir, readdir, readFile, rm, writeFile } from "node:fs/promises";

const out = process.argv[2] ?? "../src/martensite/app/static";

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
const how = {
  bundle: true,
  target: ["es2022", "chrome125", "firefox128", "safari18"],
  minify: true,
  jsx: "automatic",
  jsxImportSource: "preact",
  charset: "utf8",
};
const { metafile } = await build({
  ...how,
  metafile: true,
  entryPoints: { bench: "src/main.tsx", notebook: "src/notebook/main.tsx" },
  outdir: out,
  entryNames: "[name]",
  chunkNames: "[name]-[hash]",
  splitting: true,
  format: "esm",
  legalComments: "linked",
});
// a notebook starts a worker from its text, which can import no file
await build({ ...how, entryPoints: { engine: "src/engine/worker.ts", gif: "src/scene/gif.worker.ts" }, outdir: out, format: "esm" });
for (const name of await readdir("public")) await copyFile(`public/${name}`, `${out}/${name}`);

// what the bench needs is fetched at once, not when what needs it was read; the mechanism in space comes later
const files = Object.entries(metafile.outputs).map(([path, made]) => ({ name: path.split("/").at(-1), ...made }));
/** Names of the modules that an entry point imports, itself first; those imported later only for `kinds` that say so. */
function listImported(entryPoint, ...kinds) {
  const found = new Set([files.find((one) => one.entryPoint === entryPoint).name]);
  for (const name of found) {
    for (const { path, kind } of files.find((one) => one.name === name).imports) {
      if (kinds.includes(kind)) found.add(path.split("/").at(-1));
    }
  }
  return [...found];
}
const links = listImported("src/pages/bench.tsx", "import-statement").map((name) => `    <link rel="modulepreload" href="${name}">\n`).join("");
const index = await readFile(`${out}/index.html`, "utf8");
// browsers fetch a linked icon again with every change of the address
const icon = `data:image/svg+xml;base64,${(await readFile("public/icon.svg")).toString("base64")}`;
await writeFile(`${out}/index.html`, index.replace('href="icon.svg"', () => `href="${icon}"`).replace("  </head>", () => `${links}  </head>`));

/** A page in one file, which loads nothing by itself. */
async function inline(folder, script, define = {}) {
  const { outputFiles } = await build({
    ...how, define, entryPoints: [`src/${folder}/${script}`], outdir: folder, write: false, format: "iife", legalComments: "inline",
  });
  const [code, styles] = [".js", ".css"].map((ending) => outputFiles.find((one) => one.path.endsWith(ending)).text);
  const page = await readFile(`src/${folder}/page.html`, "utf8");
  return page.replace("STYLES", () => styles).replace("SCRIPT", () => code.replaceAll("</script", "<\\/script"));
}

// the page of a report, into which data are put; the widget of a notebook, which loads the modules of the page
await writeFile(`${out}/report.html`, await inline("report", "main.tsx"));
const FILES = JSON.stringify(["bench.css", ...listImported("src/notebook/main.tsx", "import-statement", "dynamic-import")]);
await build({
  ...how, entryPoints: { widget: "src/notebook/widget.ts" }, outdir: out, format: "esm",
  define: { PAGE: JSON.stringify(await inline("notebook", "loader.ts", { FILES })) },
});
