// @ts-check
// The program of a website's page: there is no file, so this browser keeps it. A link may bring another one.

import { find, svgAddress } from "../base/elements.js"
import { store, stored } from "../base/storage.js"
import { REPLACED } from "../editor/draft.js"
import { workIn } from "./link.js"

const KEY = "improv.program"
const STILL = "improv.still" // the picture of its paths
const LONGEST_STILL = 200_000 // characters
const FIRST = `# A robot, a dollar sign, and what the robot does. Change it and play it again.
beat 60
turtle1 $ repeat 4 (forward left)
`

const NO_ROOM = "this browser has no room for another dance: save yours as a file, with Share, and open the link again"

/**
 * A program as saved last, its improv.toml, and whether a link brought both, and nobody has changed them since then.
 * @typedef {{ text: string, revision: string, toml: string, linked?: boolean }} Program
 */

export const path = "dance.improv"

/**
 * The program to begin with, the beat at which it begins first, and a line if the address holds one that can't be
 * opened. A program from a link replaces the stored one, which the page then offers, unless it came by a link, too.
 * @returns {Promise<{ program: Program, beat: number, problem: string }>}
 */
export async function openProgram() {
  addEventListener("hashchange", async () => (await workIn(location.hash)) !== null && location.reload())
  const before = storedProgram()
  const work = await workIn(location.hash)
  if (work === null) return { program: before ?? { text: FIRST, revision: "0", toml: "" }, beat: 0, problem: "" }
  history.replaceState(null, "", location.pathname + location.search)
  const stay = (/** @type {string} */ problem) => ({ program: before ?? { text: "", revision: "0", toml: "" }, beat: 0, problem })
  if (typeof work === "string") return stay(work)
  const revision = String(Number(before?.revision ?? 0) + 1)
  const own = before && !before.linked ? before : null
  const isSame = own?.text === work.text && own.toml === work.toml
  const program = { text: work.text, revision, toml: work.toml, linked: !isSame }
  if (own && !isSame) {
    const replaced = { path, ...own, others: [], time: Date.now() }
    if (!store(`${REPLACED} ${own.revision}`, replaced)) return stay(NO_ROOM)
  }
  storeProgram(program)
  return { program, beat: work.beat, problem: "" }
}

/** Stores what was saved. Returns whether this browser had room for it. @param {Program} saved */
export function storeProgram(saved) {
  return store(KEY, saved)
}

/** Shows a picture of the paths while the page loads what draws them, if one is known. @param {Program} program */
export function showStill({ text, toml }) {
  const kept = stored(STILL)
  const picture = kept?.text === text && kept.toml === toml ? svgAddress(kept.drawn) : text === FIRST && !toml ? "first.svg" : ""
  Object.assign(find("still"), { src: picture, hidden: !picture })
}

/** @param {Program} program @param {string} drawn its paths as SVG */
export function storeStill({ text, toml }, drawn) {
  if (drawn.length < LONGEST_STILL) store(STILL, { text, toml, drawn })
}

/** @returns {Program | null} */
function storedProgram() {
  const { text, revision, toml = "", linked = false } = stored(KEY) ?? {}
  const fits = typeof text === "string" && typeof toml === "string" && /^\d{1,15}$/.test(revision)
  return fits ? { text, revision, toml, linked: linked === true } : null
}
