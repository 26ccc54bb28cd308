// Builds what the .vsix contains besides the files in this folder: the license, the bundle in dist/, and, in wheel/, the
// language server, which the extension can install. PYTHON names the Python that builds the wheel; it needs pip.

import { execFileSync } from "node:child_process"
import { copyFileSync, readFileSync, rmSync, writeFileSync } from "node:fs"
import { build } from "esbuild"

const root = "../.."
const dependencies = /^dependencies = \[$(.*?)^\]$/ms.exec(readFileSync(`${root}/pyproject.toml`, "utf8"))[1]
const requirements = [...dependencies.matchAll(/^ *"([\w-]+)/gm)].map(([, name]) => name)

copyFileSync(`${root}/LICENSE`, "LICENSE")
const common = { bundle: true, minify: true, format: "cjs", external: ["vscode"] }
await build({
  ...common,
  entryPoints: ["src/extension.ts"],
  outfile: "dist/extension.js",
  platform: "node",
  target: "node20",
  define: { REQUIREMENTS: JSON.stringify(requirements) }, // shown before anything is installed
})
// Where VS Code runs in a browser alone, no server can be started.
await build({ ...common, entryPoints: ["src/browser.ts"], outfile: "dist/browser.js", platform: "browser", target: "es2022" })

// VS Code shows no picture of an installed extension that is not on the web or in the page itself.
const picture = `data:image/png;base64,${readFileSync("images/dancing.png", "base64")}`
writeFileSync("dist/README.md", readFileSync("README.md", "utf8").replace("images/dancing.png", picture))

rmSync("wheel", { recursive: true, force: true })
const python = process.env.PYTHON || (process.platform === "win32" ? "python" : "python3")
execFileSync(python, ["-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", "wheel", root], { stdio: "inherit" })
