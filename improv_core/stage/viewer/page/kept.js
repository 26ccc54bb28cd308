// @ts-check
// The program of a website's page: there is no file, so this browser keeps it.

const KEY = "improv.program"
const FIRST = "ada $ repeat 4 (forward left)\n"

/** @typedef {{ text: string, revision: string }} Program */

export class Kept {
  path = "dance.improv"
  /** @type {Program} */
  program

  constructor() {
    this.program = find() ?? { text: FIRST, revision: "0" }
  }

  /** Keeps what was saved. @param {Program} saved */
  keep({ text, revision }) {
    this.program = { text, revision }
    try {
      localStorage.setItem(KEY, JSON.stringify(this.program))
    } catch {
      // the draft says that this browser keeps no text
    }
  }
}

/** @returns {Program | null} */
function find() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "null")
    return typeof kept?.text === "string" && /^\d{1,15}$/.test(kept.revision) ? kept : null
  } catch {
    return null
  }
}
