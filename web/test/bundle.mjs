// Bundles a script for Node.js: node bundle.mjs SOURCE TARGET
import { build } from "esbuild";

const [source, target] = process.argv.slice(2);
await build({ entryPoints: [source], outfile: target, bundle: true, platform: "node", format: "esm", logLevel: "warning" });
