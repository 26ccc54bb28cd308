// Builds what the .vsix contains besides the files in this folder: the license, the bundle in dist/, and, in wheel/, the
// language server, which the extension can install. PYTHON names the Python that builds the wheel; it needs pip.

import { execFileSync } from "node:child_process"
import { copyFileSync, readFileSync, rmSync } from "node:fs"
import { build } from "esbuild"

const root = "../.."
const dependencies = /^dependencies = \[$(.*?)^\]$/ms.exec(readFileSync(`${root}/pyproject.toml`, "utf8"))[1]
const requirements = [...dependencies.matchAll(/^ *"([\w-]+)/gm)].map(([, name]) => name)

copyFileSync(`${root}/LICENSE`, "LICENSE")
await build({
  entryPoints: ["src/extension.ts"],
  outfile: "dist/extension.js",
  bundle: true,
  minify: true,
  platform: "node",
  target: "node20",
  external: ["vscode"],
  define: { REQUIREMENTS: JSON.stringify(requirements) }, // shown before anything is installed
})

rmSync("wheel", { recursive: true, force: true })
const python = process.env.PYTHON || (process.platform === "win32" ? "python" : "python3")
execFileSync(python, ["-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", "wheel", root], { stdio: "inherit" })
