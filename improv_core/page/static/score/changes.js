// @ts-check
// Changes of a program that begin on the page: starts, formations, the tempo, and beat 0 of its song.

/** @import { Request } from "../net/requests.js" */
/** @typedef {Extract<Request, { type: "change" }>["change"]} Change */

export const changes = {
  /** Has a change written: into the text on this page, or by an editor; null if nobody can. @type {((change: Change) => void) | null} */
  write: null,
}
