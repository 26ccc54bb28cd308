// @ts-check
// Python with all of Improv, in a worker of the browser. The page sends requests, and gets messages.

// @ts-ignore: only the website has it
import { loadPyodide } from "./pyodide/pyodide.mjs"

const FOLDER = "/lib/improv"
const of = Number(new URL(import.meta.url).searchParams.get("bytes")) // of all that is loaded
let loaded = 0
let told = 0

const plainly = self.fetch
self.fetch = async (...asked) => {
  const answer = await plainly(...asked)
  const counted = answer.body?.pipeThrough(new TransformStream({ transform: count }))
  return new Response(counted, answer)
}

/** @param {Uint8Array} piece @param {TransformStreamDefaultController} onward */
function count(piece, onward) {
  onward.enqueue(piece)
  loaded += piece.length
  if (loaded < told + of / 50) return
  told = loaded
  say({ loaded, of: Math.max(of, loaded) })
}

/** @param {import("../stage/viewer/page/worker-home.js").FromWorker} said */
const say = (said) => postMessage(said)

/**
 * @typedef {object} Home
 * @property {(text: string, toml: string, revision: number, beat: number, ready: () => void) => Promise<void>} serve
 * @property {(request: string) => void} hear
 * @property {(toml: string) => void} use
 * @property {() => string | undefined} paths
 * @property {(text: string) => string} code
 */
/** @type {Home | undefined} */
let home

onmessage = async ({ data }) => {
  if (data.program) await begin(data.program)
  else if (data.request) home?.hear(data.request)
  else if (data.toml !== undefined) home?.use(data.toml)
  else if (data.draw) say({ drawn: (data.draw.code ? home?.code(data.draw.code) : home?.paths()) ?? null })
}

/** @param {import("../stage/viewer/page/kept.js").Program & { beat: number }} program */
async function begin(program) {
  try {
    const [python, improv] = await Promise.all([
      loadPyodide({ indexURL: new URL("pyodide/", import.meta.url).href, fullStdLib: false }),
      fetch(new URL("improv.zip", import.meta.url)).then((answer) => answer.arrayBuffer()),
    ])
    python.unpackArchive(improv, "zip", { extractDir: FOLDER })
    python.runPython(`import sys; sys.path.append("${FOLDER}")`)
    const { Home } = python.pyimport("improv_core.site.home")
    const own = /** @type {Home} */ (Home((/** @type {string} */ text) => say({ message: text }), (/** @type {number} */ number) => say({ obeyed: number })))
    home = own
    await own.serve(program.text, program.toml, Number(program.revision), program.beat, () => say({ ready: true }))
  } catch (problem) {
    say({ problem: `Improv can't run here: ${String(problem).trim().split("\n").at(-1)}` })
  }
}
