// @ts-check
// Python with all of Improv, in a worker of the browser. The page sends requests, and gets messages.

import { loadPyodide } from "./pyodide/pyodide.mjs"

const FOLDER = "/lib/improv"

/** @param {import("../stage/viewer/page/worker-home.js").FromWorker} said */
const say = (said) => postMessage(said)

/** @type {{ hear: (request: string) => void, paths: () => string | undefined } | undefined} */
let home

onmessage = async ({ data }) => {
  if (data.program) await begin(data.program)
  else if (data.request) home?.hear(data.request)
  else if (data.draw) say({ paths: home?.paths() ?? null })
}

/** @param {{ text: string, revision: string }} program */
async function begin(program) {
  try {
    const [python, improv] = await Promise.all([
      loadPyodide({ indexURL: new URL("pyodide/", import.meta.url).href, fullStdLib: false }),
      fetch(new URL("improv.zip", import.meta.url)).then((answer) => answer.arrayBuffer()),
    ])
    python.unpackArchive(improv, "zip", { extractDir: FOLDER })
    python.runPython(`import sys; sys.path.append("${FOLDER}")`)
    const { Home } = python.pyimport("improv_core.site.home")
    home = Home((/** @type {string} */ text) => say({ message: text }), (/** @type {number} */ number) => say({ obeyed: number }))
    await home.serve(program.text, Number(program.revision), () => say({ ready: true }))
  } catch (problem) {
    say({ problem: `Improv can't run here: ${String(problem).trim().split("\n").at(-1)}` })
  }
}
