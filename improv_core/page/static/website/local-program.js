// @ts-check
// The program of a website's page: there is no file, so this browser keeps it. A link may bring another one.

import { find, svgAddress } from "../base/elements.js"
import { store, stored } from "../base/storage.js"
import { REPLACED } from "../editor/draft.js"
import { workIn } from "./link.js"
import { svgOf } from "./still.js"

/** @import { Still } from "./still.js" */

const KEY = "improv.program"
const STILL = "improv.still" // the picture of its paths
const LONGEST_STILL = 200_000 // characters
const FIRST = `# A robot, a dollar sign, and what the robot does. Change it and play it again.
beat 60
turtle1 $ repeat 4 (forward left)
`

/** @type {Still} */
const FIRST_STILL = [[0, 0, 400, 400, 0, 0, -400, -400, 0, 0, 400]]

const NO_ROOM = "this browser has no room for another dance: save yours as a file, with Share, and open the link again"

/**
 * A program as saved last, its improv.toml, and whether a link brought both, and nobody has changed them since then.
 * @typedef {{ text: string, revision: string, toml: string, linked?: boolean }} Program
 */

export const path = "dance.improv"

/**
 * The program to begin with, the beat at which it begins first, the picture of its paths, if there is one, and a line
 * if the address holds one that can't be opened. A program from a link replaces the stored one, which the page then offers, unless it came by a link, too.
 * @returns {Promise<{ program: Program, beat: number, still: Still, problem: string }>}
 */
export async function openProgram() {
  addEventListener("hashchange", async () => (await workIn(location.hash)) !== null && location.reload())
  const before = storedProgram()
  const work = await workIn(location.hash)
  if (work === null) return { program: before ?? { text: FIRST, revision: "0", toml: "" }, beat: 0, still: [], problem: "" }
  history.replaceState(null, "", location.pathname + location.search)
  const stay = (/** @type {string} */ problem) => ({ program: before ?? { text: "", revision: "0", toml: "" }, beat: 0, still: [], problem })
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
  return { program, beat: work.beat, still: work.still, problem: "" }
}

/** Stores what was saved. Returns whether this browser had room for it. @param {Program} saved */
export function storeProgram(saved) {
  return store(KEY, saved)
}

/**
 * Shows a picture of the paths while the page loads what draws them, if one is known.
 * @param {Program} program
 * @param {Still} linked with the link
 */
export function showStill({ text, toml }, linked) {
  const kept = stored(STILL)
  const still = text === FIRST && !toml ? FIRST_STILL : linked
  const drawn = kept?.text === text && kept.toml === toml ? kept.drawn : still.length ? svgOf(still) : ""
  Object.assign(find("still"), { src: drawn && svgAddress(drawn), hidden: !drawn })
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
