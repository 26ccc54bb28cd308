// @ts-check
// Programs as files: where browsers let pages choose a file to write, there, and elsewhere as a download.

import { download } from "../base/elements.js"

/**
 * @typedef {object} Chosen a file that somebody has chosen to write
 * @property {string} name
 * @property {() => Promise<{ write: (text: string) => Promise<void>, close: () => Promise<void> }>} createWritable
 */
/** @typedef {(options: object) => Promise<Chosen>} Save */

const MAX_BYTES = 400_000
const MAX_CHARACTERS = 100_000 // characters
const TYPES = [{ description: "Improv", accept: { "text/plain": [".improv"] } }]

/**
 * Saves a text as a file that somebody chooses. Promises the line to show; empty if nobody has chosen one.
 * @param {string} name to begin with
 * @param {string} text
 */
export async function saveText(name, text) {
  const choose = /** @type {Save | undefined} */ (Reflect.get(window, "showSaveFilePicker"))
  if (!choose) {
    download(name, new Blob([text], { type: "text/plain;charset=utf-8" }))
    return "Saved where this browser keeps downloads."
  }
  try {
    const chosen = await choose({ suggestedName: name, types: TYPES })
    const file = await chosen.createWritable()
    await file.write(text)
    await file.close()
    return `Saved as ${chosen.name}.`
  } catch (problem) {
    const wasLeft = problem instanceof DOMException && problem.name === "AbortError" // the window to choose a file
    return wasLeft ? "" : `Not saved: ${problem}`
  }
}

/** The program in a file; null if it is too long or no text. @param {File} file */
export async function textOf(file) {
  if (file.size > MAX_BYTES) return null
  try {
    const text = new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer()).replaceAll("\r\n", "\n")
    return text.length <= MAX_CHARACTERS ? text : null
  } catch {
    return null
  }
}
