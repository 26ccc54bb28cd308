// @ts-check
// The program's text; words light up while they play.

import { wordStarts } from "./items.js"
import { partsOf } from "./lookahead.js"

/** @import { Clock } from "./clock.js" */
/** @import { Words } from "./items.js" */
/** @import { Lookahead } from "./lookahead.js" */
/** @import { Messages } from "../net/messages.js" */


const COMMENT = /#.*/g
const WORD = /[^\s()[\]|#=$]+/gu
const MOST_CHARACTERS = 200_000 // characters: beyond, a browser would take long to lay them out

export class Score {
  #text
  /** @type {Map<number, HTMLElement>} */
  #words = new Map() // by offsets in code points
  /** @type {Map<HTMLElement, string>} */
  #lit = new Map() // with their colors

  /** @param {HTMLElement} text */
  constructor(text) {
    this.#text = text
  }

  /**
   * Shows a program; `words` are those that move robots.
   * @param {Messages["score"]} score
   */
  show({ text, words }) {
    this.#words.clear()
    this.#lit.clear()
    let at = 0 // in code points, as the server counts
    const lines = text.slice(0, MOST_CHARACTERS).split("\n")
    this.#text.replaceChildren(
      ...lines.map((line) => {
        const element = this.#line(line, at, words)
        at += Array.from(line).length + 1
        return element
      }),
    )
  }

  /**
   * Lights words, given by offset, in the colors of the robots that play them. Some of them are words of `poses`.
   * @param {Map<number, string>} places
   * @param {Set<number>} poses
   */
  light(places, poses) {
    const wanted = new Map()
    for (const [at, color] of places) {
      const word = this.#words.get(at)
      if (word) wanted.set(word, color)
      if (poses.has(at)) word?.classList.add("moving")
    }
    for (const [word] of this.#lit) if (!wanted.has(word)) word.classList.remove("lit")
    for (const [word, color] of wanted) {
      if (this.#lit.get(word) === color) continue
      word.classList.add("lit")
      word.style.setProperty("--robot", color)
    }
    this.#lit = wanted
    this.#keepInView()
  }

  /**
   * @param {string} line
   * @param {number} start
   * @param {Words} moving
   */
  #line(line, start, moving) {
    const element = document.createElement("div")
    const comment = line.search(COMMENT)
    const code = comment < 0 ? line : line.slice(0, comment)
    let done = 0
    for (const { 0: word, index } of code.matchAll(WORD)) {
      const span = document.createElement("span")
      span.textContent = word
      if (Object.hasOwn(moving, word)) span.className = "moving"
      element.append(code.slice(done, index), span)
      done = index + word.length
      this.#words.set(start + Array.from(code.slice(0, index)).length, span)
    }
    element.append(code.slice(done))
    if (comment >= 0) {
      const quiet = document.createElement("i")
      quiet.textContent = line.slice(comment)
      element.append(quiet)
    }
    if (!line) element.append("\u200b") // keeps an empty line's height
    return element
  }

  /** Scrolls only if none of the words that move robots is visible. */
  #keepInView() {
    const view = this.#text.getBoundingClientRect()
    if (!view.height || this.#text.scrollHeight <= this.#text.clientHeight) return
    /** @type {HTMLElement | null} */
    let nearest = null
    for (const word of this.#lit.keys()) {
      if (!word.classList.contains("moving")) continue // a name that uses what plays
      const { top, bottom } = word.getBoundingClientRect()
      if (top >= view.top && bottom <= view.bottom) return
      nearest ??= word
    }
    if (nearest) this.#text.scrollTop += nearest.getBoundingClientRect().top - view.top - view.height / 3
  }
}

/** Lights words while they play, in the color of their robot, or of the text if several robots play them. */
export class PlayingWords {
  #score
  #clock
  #lit = ""
  /** @type {string[]} */
  #points = [] // of the text

  /**
   * @param {Pick<Score, "show" | "light">} score
   * @param {Clock} clock
   */
  constructor(score, clock) {
    this.#score = score
    this.#clock = clock
  }

  /**
   * Shows another program.
   * @param {Messages["score"]} score
   */
  showText(score) {
    this.#score.show(score)
    this.#points = Array.from(score.text)
    this.forget()
  }

  /** Lights everything again: the text has changed, or the colors. */
  forget() {
    this.#lit = ""
  }

  /**
   * Lights what plays at a beat; nothing without a lookahead.
   * @param {Lookahead | null} lookahead
   * @param {number} beat
   * @param {(index: number) => string} colorOf
   * @param {string} shared
   */
  show(lookahead, beat, colorOf, shared) {
    /** @type {Map<number, string>} */
    const places = new Map()
    /** @type {Set<number>} */
    const poses = new Set()
    const names = lookahead ? Object.keys(lookahead.score.robots) : []
    names.forEach((name, index) => {
      if (!lookahead || this.#clock.isSilent(name)) return
      const color = colorOf(index)
      for (const part of partsOf(lookahead.score, name)) {
        const stretch = lookahead.at(name, part, beat)
        if (!stretch || stretch.start > beat) continue
        for (const span of stretch.words) {
          const words = wordStarts(this.#points, span)
          for (const at of words) {
            places.set(at, (places.get(at) ?? color) === color ? color : shared)
            if (words.length > 1) poses.add(at)
          }
        }
      }
    })
    const now = JSON.stringify([...places])
    if (now === this.#lit) return
    this.#lit = now
    this.#score.light(places, poses)
  }
}
