// @ts-check
// Python with all of Improv, in a worker of the browser. The page sends requests, and gets messages.

// @ts-ignore: only the website has it
import { loadPyodide } from "./pyodide/pyodide.mjs"

const FOLDER = "/lib/improv"
const asked = new URL(import.meta.url).searchParams
let of = Number(asked.get("bytes")) // of all that is loaded
let loaded = 0
let told = 0

const COMPILED = `improv compiled ${new URL(".", import.meta.url)}`
const kept = `compiled-${asked.get("code")}.zip`

const plainly = self.fetch
self.fetch = async (what, ...how) => {
  const isPacked = String(what instanceof Request ? what.url : what).endsWith(".wasm") // most web servers compress nothing
  const answer = await plainly(isPacked ? `${what instanceof Request ? what.url : what}.packed` : what, ...how)
  const counted = answer.body?.pipeThrough(new TransformStream({ transform: count }))
  if (!isPacked || !answer.ok) return new Response(counted, answer)
  return new Response(counted?.pipeThrough(new DecompressionStream("gzip")), { headers: { "Content-Type": "application/wasm" } })
}

/** @param {Uint8Array} piece @param {TransformStreamDefaultController} onward */
function count(piece, onward) {
  onward.enqueue(piece)
  loaded += piece.length
  if (loaded >= 0.98 * of) say({ stage: "Starting Python" })
  else if (loaded >= told + of / 50) say({ stage: `Loading Improv: ${megabytes((told = loaded))} of ${megabytes(of)} MB` })
}

/** @param {number} bytes */
const megabytes = (bytes) => (bytes / 1e6).toFixed(1)

/** @param {import("../page/static/net/worker-backend.js").FromWorker} said */
const say = (said) => postMessage(said)

/**
 * @typedef {object} BrowserBackend
 * @property {(text: string, toml: string, revision: number, beat: number, ready: () => void) => Promise<void>} serve
 * @property {(request: string) => void} hear
 * @property {(toml: string) => void} use
 * @property {() => string | undefined} paths
 * @property {(text: string) => string} code
 */
/** @type {BrowserBackend | undefined} */
let home

onmessage = async ({ data }) => {
  if (data.program) await begin(data.program)
  else if (data.request) home?.hear(data.request)
  else if (data.toml !== undefined) home?.use(data.toml)
  else if (data.draw) say({ drawn: (data.draw.code ? home?.code(data.draw.code) : home?.paths()) ?? null })
}

/** The modules of Improv, as source. */
async function load() {
  const answer = await fetch(new URL("improv.zip", import.meta.url))
  return answer.arrayBuffer()
}

/** The same modules as this browser has compiled them on an earlier visit; null if it hasn't, or keeps nothing. */
async function findCompiled() {
  try {
    const found = await (await caches.open(COMPILED)).match(kept)
    return found ? await found.arrayBuffer() : null
  } catch {
    return null
  }
}

/** @param {Uint8Array<ArrayBuffer>} archive */
async function keepCompiled(archive) {
  try {
    await caches.delete(COMPILED)
    await (await caches.open(COMPILED)).put(kept, new Response(archive))
  } catch {
    // they are compiled again next time
  }
}

/**
 * What runs. If it can't be imported as it was compiled, the source takes its place.
 * @param {any} python
 * @param {ArrayBuffer} archive
 * @param {boolean} isCompiled
 * @returns {Promise<any>}
 */
async function imported(python, archive, isCompiled) {
  try {
    python.unpackArchive(archive, "zip", { extractDir: FOLDER })
    return python.pyimport("improv_core.website.browser_session")
  } catch (problem) {
    if (!isCompiled) throw problem
    await caches.delete(COMPILED)
    return imported(python, await load(), false)
  }
}

/** @param {import("../page/static/website/local-program.js").Program & { beat: number }} program */
async function begin(program) {
  try {
    const compiled = await findCompiled()
    if (compiled) of -= Number(asked.get("source"))
    const [python, improv] = await Promise.all([
      loadPyodide({ indexURL: new URL("pyodide/", import.meta.url).href, fullStdLib: false }),
      compiled ?? load(),
    ])
    python.runPython(`import sys; sys.path.append("${FOLDER}"); sys.dont_write_bytecode = False`)
    say({ stage: compiled ? "Starting Improv" : "Preparing Improv: the first time takes longest" })
    const { BrowserBackend } = await imported(python, improv, compiled !== null)
    if (!compiled) keepCompiled(python.pyimport("improv_core.website.compile_cache").compiled(FOLDER).toJs())
    const own = /** @type {BrowserBackend} */ (BrowserBackend((/** @type {string} */ text) => say({ message: text }), (/** @type {number} */ number) => say({ obeyed: number })))
    home = own
    await own.serve(program.text, program.toml, Number(program.revision), program.beat, () => say({ ready: true }))
  } catch (problem) {
    say({ problem: `Improv can't run here: ${String(problem).trim().split("\n").at(-1)}` })
  }
}
