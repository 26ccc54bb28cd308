// @ts-check
// Improv in a worker of this browser, in place of a server. If it hangs, it is ended, and another one begins.

import { isClass } from "../website/class.js"
import { openProgram, path, showStill, storeProgram, storeStill } from "../website/local-program.js"
import { notices } from "../base/notices.js"
import { PressedStops } from "./stops.js"

/** @import { Program } from "../website/local-program.js" */
/** @typedef {{ message: string } | { ready: true } | { stage: string } | { obeyed: number } | { drawn: string | null } | { problem: string }} FromWorker */

const address = document.querySelector('meta[name="improv-worker"]')?.getAttribute("content") ?? ""
const STOP_TIMEOUT = 8000 // milliseconds after which a worker that doesn't stop is ended
const NO_ROOM = "not saved: this browser has no room for it, so save it as a file, with Share"
const NEWER = "A newer version of this website is here. Reload the page to use it: your text stays."

/** @type {Worker | undefined} */
let worker
/** @type {((drawn: string | null) => void)[]} */
const waiting = [] // for what the worker draws
/** @type {Program} */
let program
let beat = 0 // at which the program begins when it is first played as it was opened

/**
 * Keeps a worker. Returns a function that sends a request.
 * @param {(message: Message) => void} onMessage
 * @param {(now: "open" | "lost" | "refused") => void} onChange
 * @returns {(request: PageRequest) => void}
 */
export function connect(onMessage, onChange) {
  const stops = new PressedStops()
  let hung = 0 // the timer
  let ready = false
  let problem = "" // with the link
  let isKept = true

  function begin() {
    ready = false
    worker = new Worker(new URL(address, document.baseURI), { type: "module" })
    worker.onmessage = (event) => take(event.data)
    worker.onerror = () => notices.load("This browser can't run Improv: open this page in a current version of Firefox, Chrome, or Safari.")
    const { text, revision, toml } = program
    worker.postMessage({ program: { text, revision, toml, beat } })
  }

  /** @param {FromWorker} said */
  function take(said) {
    if ("message" in said) {
      /** @type {Message} */
      const message = JSON.parse(said.message)
      if (message.type === "source") {
        const linked = program.linked && message.text === program.text
        program = { ...program, text: message.text, revision: message.revision, linked }
        isKept = storeProgram(program)
        if (!isKept) return // for the page, the text stays unsaved
      }
      onMessage(message.type === "write" && !isKept ? { ...message, problem: NO_ROOM } : message)
    } else if ("ready" in said) {
      ready = true
      if (!isClass) keepSite() // the server of a class has it only as long as the class
      onChange("open")
      if (problem) notices.load(problem)
    } else if ("stage" in said) notices.load(problem ? `${problem} (${said.stage})` : said.stage)
    else if ("obeyed" in said) stops.confirm(said.obeyed)
    else if ("drawn" in said) waiting.shift()?.(said.drawn)
    else notices.load(said.problem)
  }

  function press() {
    if (!stops.waiting) {
      clearTimeout(hung)
      hung = window.setTimeout(() => stops.waiting && replace(), STOP_TIMEOUT)
    }
    return stops.press()
  }

  function replace() {
    worker?.terminate()
    onChange("lost")
    stops.confirm()
    begin()
  }

  openProgram().then((opened) => {
    program = opened.program
    beat = opened.beat
    onMessage({ type: "source", path, text: program.text, revision: program.revision, toml: program.toml })
    problem = opened.problem
    if (problem) notices.load(problem)
    showStill(program, opened.still)
    begin()
  })
  return (request) => {
    const sent = request.type === "stop" ? { type: "press", number: press() } : request
    if (ready) worker?.postMessage({ request: JSON.stringify(sent) })
    else if (request.type === "stop") stops.confirm() // nothing moves yet
  }
}

/**
 * Has the browser keep the website, so that it needs no network next time, where browsers allow that. A newer version
 * takes the place of the kept one from here on: not before, because parts of both would be loaded.
 */
async function keepSite() {
  const { serviceWorker } = navigator
  if (serviceWorker?.controller) serviceWorker.addEventListener("controllerchange", () => notices.load(NEWER), { once: true })
  try {
    const site = await serviceWorker?.register(new URL("service-worker.js", document.baseURI))
    const takeOver = () => site?.waiting?.postMessage("take over")
    const watch = () => site?.installing?.addEventListener("statechange", takeOver)
    takeOver()
    watch()
    site?.addEventListener("updatefound", watch)
  } catch {
    // it needs the network next time
  }
}

/** Promises the paths as SVG; null if there are none. */
export async function drawPaths() {
  const drawn = await draw({ paths: true })
  if (drawn) storeStill(program, drawn)
  return drawn
}

/** Promises a QR code that holds a text, as SVG. @param {string} text */
export const drawCode = (text) => draw({ code: text })

/** The improv.toml of the program. */
export const getToml = () => program.toml

/** Has the program use another improv.toml. Returns whether this browser had room for it. @param {string} toml */
export function setToml(toml) {
  program = { ...program, toml, linked: false }
  worker?.postMessage({ toml })
  return storeProgram(program)
}

/** @param {{ paths: true } | { code: string }} what @returns {Promise<string | null>} */
function draw(what) {
  return new Promise((done) => {
    waiting.push(done)
    worker?.postMessage({ draw: what })
  })
}
