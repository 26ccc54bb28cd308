// @ts-check
// The list of words that may be written next. It never takes Enter, unless somebody has gone to a word with the arrows.
// On phones and tablets, they stand in the row of words to tap instead.

import { element, find, syncChildren, write } from "../base/elements.js"
import { WORDS, wordButton } from "./word-row.js"

const MAX_TO_TAP = 12 // words
export const touches = matchMedia("(pointer: coarse)")

/** @typedef {{ word: string, about: string }} Word */

export class Completions {
  #list = find("completions")
  #row = find("word-completions")
  #owner
  #pick
  #chosen = -1

  /**
   * `pick` gets the word that somebody chooses.
   * @param {HTMLElement} owner the text control, which keeps the focus
   * @param {(word: string) => void} pick
   */
  constructor(owner, pick) {
    this.#owner = owner
    this.#pick = pick
    this.#list.addEventListener("pointerdown", (event) => event.preventDefault()) // the focus stays
    this.#list.addEventListener("click", (event) => {
      if (event.target instanceof Element) this.#take(event.target.closest("li")?.dataset.name)
    })
    this.#row.addEventListener("click", ({ target }) => {
      if (target instanceof HTMLButtonElement) this.#take(target.dataset.name)
    })
  }

  get open() {
    return !this.#list.hidden
  }

  /** @param {Word[]} words @param {{ left: number, top: number, bottom: number }} place of what is written already */
  show(words, place) {
    this.#leave()
    const names = words.map(({ word }) => word)
    syncChildren(this.#list, names, (name) =>
      element("li", { role: "option", id: `completion-${name}`, ariaSelected: "false" }, element("b", { textContent: name }), " ", element("span")),
    )
    this.#items.forEach((item, i) => item.lastElementChild && write(item.lastElementChild, words[i].about))
    if (!this.open) this.#list.hidden = false
    placeBeside(this.#list, place)
  }

  /**
   * Has words be tapped.
   * @param {Word[]} words
   * @param {string} begun what is written already; if that is nothing, the words that are always there are left out
   */
  tap(words, begun) {
    if (!touches.matches) return
    const offered = words.map(({ word }) => word).filter((word) => begun || !WORDS.includes(word))
    syncChildren(this.#row, offered.slice(0, MAX_TO_TAP), wordButton)
  }

  /** @param {{ left: number, top: number, bottom: number }} place of what is written already, now */
  move(place) {
    placeBeside(this.#list, place)
  }

  hide() {
    this.tap([], "")
    this.#leave()
    if (this.open) this.#list.hidden = true
  }

  /** Chooses none of the words. */
  #leave() {
    if (this.#chosen < 0) return
    this.#items[this.#chosen].ariaSelected = "false"
    this.#chosen = -1
    this.#owner.removeAttribute("aria-activedescendant")
  }

  /** Returns whether a key was for the list. @param {KeyboardEvent} event */
  takes({ key, shiftKey }) {
    if (!this.open || shiftKey) return false
    if (key === "ArrowDown" || key === "ArrowUp") this.#choose(key === "ArrowDown" ? 1 : -1)
    else if (key === "Escape") this.hide()
    else if (key === "Tab") this.#take(this.#items[Math.max(this.#chosen, 0)]?.dataset.name)
    else if (key === "Enter" && this.#chosen >= 0) this.#take(this.#items[this.#chosen].dataset.name)
    else return false
    return true
  }

  /** @param {number} step */
  #choose(step) {
    const items = this.#items
    const next = ((this.#chosen < 0 && step < 0 ? 0 : this.#chosen) + step + items.length) % items.length
    this.#leave()
    this.#chosen = next
    items[next].ariaSelected = "true"
    items[next].scrollIntoView({ block: "nearest" })
    this.#owner.setAttribute("aria-activedescendant", items[next].id)
  }

  /** @param {string | undefined} word */
  #take(word) {
    if (!word) return
    this.hide()
    this.#pick(word)
  }

  get #items() {
    return /** @type {HTMLElement[]} */ ([...this.#list.children])
  }
}

/**
 * Puts a box below a place, or above it if there is no room.
 * @param {HTMLElement} box
 * @param {{ left: number, top: number, bottom: number }} place
 */
export function placeBeside(box, { left, top, bottom }) {
  const { width, height } = box.getBoundingClientRect()
  box.style.left = `${Math.max(4, Math.min(left, innerWidth - width - 4))}px`
  box.style.top = `${bottom + height + 4 < innerHeight || top < height + 4 ? bottom + 4 : top - height - 4}px`
}
