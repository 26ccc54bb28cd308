// @ts-check
// Improv in a worker of this browser, in place of a server. If it hangs, it is ended, and another one begins.

import { Kept } from "./kept.js"
import { read } from "./messages.js"

/** @import { Message } from "./messages.js" */
/** @import { Request } from "./requests.js" */
/** @typedef {{ message: string } | { ready: true } | { loaded: number, of: number } | { obeyed: number } | { paths: string | null } | { problem: string }} FromWorker */

const LATE = 300 // milliseconds after which people are told that a stop is not confirmed
const HUNG = 8000 // milliseconds after which a worker that doesn't stop is ended

/** @type {Worker | undefined} */
let worker
/** @type {((paths: string | null) => void)[]} */
const waiting = [] // for paths

/**
 * Keeps a worker. `onStop` gets whether a stop has been waiting for a while to be obeyed, and `onLoad` a line about what
 * is still being loaded. Returns a function that sends a request.
 * @param {(message: Message) => void} onMessage
 * @param {(now: "open" | "lost" | "refused") => void} onChange
 * @param {(waits: boolean) => void} onStop
 * @param {(line: string) => void} onLoad
 * @returns {(request: Request) => void}
 */
export function connect(onMessage, onChange, onStop, onLoad) {
  const kept = new Kept()
  let pressed = 0
  let obeyed = 0
  let timers = /** @type {number[]} */ ([])
  let ready = false

  function begin() {
    ready = false
    worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" })
    worker.onmessage = (event) => take(event.data)
    worker.onerror = () => onLoad("This browser can't run Improv: open this page in a current version of Firefox, Chrome, or Safari.")
    worker.postMessage({ program: kept.program })
  }

  /** @param {FromWorker} said */
  function take(said) {
    if ("message" in said) {
      const message = read(said.message)
      if (message?.type === "source") kept.keep(message)
      if (message) onMessage(message)
    } else if ("ready" in said) {
      ready = true
      onLoad("")
      onChange("open")
    } else if ("loaded" in said) onLoad(`Loading Improv: ${megabytes(said.loaded)} of ${megabytes(said.of)} MB`)
    else if ("obeyed" in said) confirm(said.obeyed)
    else if ("paths" in said) waiting.shift()?.(said.paths)
    else onLoad(said.problem)
  }

  function press() {
    pressed++
    if (!timers.length) timers = [window.setTimeout(() => onStop(true), LATE), window.setTimeout(replace, HUNG)]
    return pressed
  }

  /** @param {number} number of a stop that was obeyed, and with it all earlier ones */
  function confirm(number) {
    obeyed = Math.max(number, obeyed)
    if (obeyed < pressed) return
    timers.forEach(clearTimeout)
    timers = []
    onStop(false)
  }

  function replace() {
    worker?.terminate()
    onChange("lost")
    confirm(pressed)
    begin()
  }

  setTimeout(() => onMessage({ type: "source", path: kept.path, ...kept.program }))
  begin()
  return (request) => {
    const sent = request.type === "stop" ? { type: "press", number: press() } : request
    if (ready) worker?.postMessage({ request: JSON.stringify(sent) })
    else if (request.type === "stop") confirm(pressed) // nothing moves yet
  }
}

/** Promises the paths as SVG; null if there are none. @returns {Promise<string | null>} */
export function drawPaths() {
  return new Promise((done) => {
    waiting.push(done)
    worker?.postMessage({ draw: true })
  })
}

/** @param {number} bytes */
function megabytes(bytes) {
  return (bytes / 1e6).toFixed(1)
}
