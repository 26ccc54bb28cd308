// @ts-check
// The words that are offered for what is written at the cursor, from the question to the choice.

import { find } from "../base/elements.js"
import { send } from "../net/send.js"
import { Completions, touches } from "./completions.js"

/** @import { CodePoints } from "../base/code-points.js" */
/**
 * @typedef {object} Text
 * @property {() => number | null} sent the number of the text, once it was sent to the server
 * @property {() => CodePoints} codePoints
 * @property {(offset: number) => { left: number, top: number, bottom: number }} place of a letter on the page
 * @property {(text: string) => void} replace puts another text in, as if it had been typed
 */

const PAUSE = 150 // milliseconds without a key until words are looked for, unless some are listed already
const BEGUN = /[\p{L}\p{M}\p{N}_\u200C\u200D]$/u
const LETTERS = /^[\p{L}\p{M}\p{N}_\u200C\u200D]*/u

export class Offer {
  #control
  #text
  #completions
  /** @type {{ start: number, end: number, asked: boolean, isDue: boolean } | null} */
  #offering = null
  #pause = 0

  /** @param {HTMLTextAreaElement} control @param {Text} text */
  constructor(control, text) {
    this.#control = control
    this.#text = text
    this.#completions = new Completions(control, (word) => this.#pick(word))
    for (const kind of ["compositionstart", "blur", "pointerdown"]) control.addEventListener(kind, () => this.end())
    control.addEventListener("click", () => touches.matches && this.begin(false)) // to tap, where no list opens
  }

  /** Returns whether a key chooses among the words. @param {KeyboardEvent} event */
  takes(event) {
    return this.#completions.takes(event)
  }

  /** @param {boolean} asked whether somebody has asked for it, instead of only writing */
  begin(asked) {
    const { value, selectionStart, selectionEnd: end } = this.#control
    if (selectionStart !== end) {
      this.#offering = null
      return
    }
    // Nothing is listed for no letter: the server need not look.
    if (!asked && !touches.matches && !BEGUN.test(value.slice(Math.max(end - 2, 0), end))) return this.end()
    // Until the server answers, a word that is shown also takes the place of what has been typed since.
    let start = Math.min(this.#offering?.start ?? end, end)
    if (lettersOf(value.slice(start, end)).length < end - start) {
      this.end()
      start = end
    }
    const offering = (this.#offering = { start, end, asked, isDue: asked || this.#completions.open })
    clearTimeout(this.#pause)
    this.#pause = window.setTimeout(() => {
      offering.isDue = true
      this.ask()
    }, offering.isDue ? 0 : PAUSE)
  }

  /** Asks for the words, once that is due and the server was sent the text. */
  ask() {
    const number = this.#text.sent()
    if (!this.#offering?.isDue || number === null) return
    send({ type: "complete", number, offset: this.#text.codePoints().toPoints(this.#control.selectionEnd) })
  }

  /** @param {Messages["complete"]} message */
  take(message) {
    const { number, words } = message
    if (number !== this.#text.sent()) return
    const { start: from, end: to } = this.#text.codePoints().inUnits(message)
    const offering = this.#offering
    if (!offering || offering.end !== this.#control.selectionEnd || to !== offering.end) return
    const begun = this.#control.value.slice(from, to)
    const complete = words.some(({ word }) => word === begun)
    const isListed = words.length > 0 && (offering.asked || (begun !== "" && !complete))
    if (!isListed) this.end()
    this.#offering = { ...offering, start: from }
    this.#completions.tap(complete ? [] : words, begun)
    if (isListed) this.#completions.show(words, this.#text.place(from))
  }

  /** The text has scrolled: the words go along, as long as what they belong to is in view. */
  move() {
    if (!this.#offering || !this.#completions.open) return
    const { top, bottom } = find("paper").getBoundingClientRect()
    const place = this.#text.place(this.#offering.start)
    if (place.bottom < top || place.top > bottom) this.end()
    else this.#completions.move(place)
  }

  end() {
    this.#offering = null
    this.#completions.hide()
  }

  /** Writes a word in place of what is begun, and of its own end behind the cursor. @param {string} word */
  #pick(word) {
    if (!this.#offering) return
    const { start, end } = this.#offering
    this.#offering = null
    const { value } = this.#control
    const rest = lettersOf(value.slice(end))
    this.#text.replace(value.slice(0, start) + word + value.slice(word.endsWith(rest) ? end + rest.length : end))
    this.#control.setSelectionRange(start + word.length, start + word.length)
  }
}

/** The letters of a word with which a text begins. @param {string} text */
function lettersOf(text) {
  return LETTERS.exec(text)?.[0] ?? ""
}
