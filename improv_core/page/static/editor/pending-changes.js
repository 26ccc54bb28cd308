// @ts-check
// New starts of robots: the page asks for their lines one after the other, each for the text after the previous one.

import { send } from "../net/send.js"

/** @import { Edit } from "./edits.js" */
/** @import { Change } from "../score/changes.js" */
/**
 * @typedef {object} Text
 * @property {() => number | null} known the number of the text, once the server has it
 * @property {() => number} cursor its place, in code points
 * @property {(edits: Edit[], bends: boolean, again: boolean) => boolean} edit makes edits, which count in code points; `again` if they go on
 *   with the latest one. Returns whether they can be undone
 * @property {(problem: string) => void} say why nothing was written, if there is a reason
 * @property {() => void} save saves the text
 */

export class PendingChanges {
  #text
  /** @type {Change[]} */
  #waiting = []
  #asked = -1 // the number of the text in the question to the server
  #bent = -1 // the number of the text that a handle or a key has made last
  #saves = false // whether the text is to be saved after all of them

  /** @param {Text} text */
  constructor(text) {
    this.#text = text
  }

  /** True if some are not written yet. */
  get open() {
    return this.#waiting.length > 0
  }

  /** @param {Change} change */
  add(change) {
    // A hand moves on while its movement is being written: only its latest place counts.
    if (change.type === "bend" && this.#waiting.at(-1)?.type === "bend" && (this.#waiting.length > 1 || this.#asked < 0)) this.#waiting.pop()
    this.#waiting.push(change)
    this.ask()
  }

  /** Asks for the next one: the server has the text now. */
  ask() {
    const number = this.#text.known()
    if (!this.open || number === null || number === this.#asked) return
    this.#asked = number
    const [change] = this.#waiting
    // The word at the cursor may have moved on since a hand or a key has bent it.
    const isBent = change.type === "bend" || change.type === "lengthen"
    send({ type: "change", number, change: isBent ? { ...change, offset: this.#text.cursor() } : change })
  }

  /** @param {Messages["change"]} message */
  take({ number, edits, problem }) {
    if (!this.open || number !== this.#text.known()) return // the page asks again, for its current text
    const change = this.#waiting.shift()
    this.#asked = -1
    this.#text.say(problem)
    const bends = change?.type === "bend" || change?.type === "lengthen"
    if (edits.length) {
      const isUndone = this.#text.edit(edits, bends, bends && this.#bent === number)
      this.#bent = bends && isUndone ? number + 1 : -1
    }
    this.ask()
    if (this.open || !this.#saves) return
    this.#saves = false
    this.#text.save()
  }

  /** Saves the text after all that wait. Returns whether there are any. */
  saveAfter() {
    this.#saves = this.open
    return this.open
  }

  /** The connection is lost: the question gets no answer. */
  forget() {
    this.#asked = -1
  }
}
