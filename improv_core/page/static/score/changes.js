// @ts-check
// Changes of a program that begin on the page: starts, formations, the tempo, and beat 0 of its song.

import { find } from "../base/elements.js"

/** @typedef {Extract<PageRequest, { type: "change" }>["change"]} Change */

export const changes = {
  /** Has a change written: into the text on this page, or by an editor; null if nobody can. @type {((change: Change) => void) | null} */
  write: null,
}

/** Shows why a change was not written, where people make changes; nothing if it was. @param {string} problem */
export function showProblem(problem) {
  for (const id of ["start-poses-problem", "sound-problem"]) Object.assign(find(id), { textContent: problem, hidden: !problem })
}
