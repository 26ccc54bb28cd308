// @ts-check
// The list of words that may be written next. It never takes Enter, unless somebody has gone to a word with the arrows.
// On phones and tablets, they stand in the row of words to tap instead.

import { find } from "./elements.js"
import { WORDS, offerToTap } from "./word-row.js"

/** @typedef {{ word: string, about: string }} Word */

export class Offers {
  #list = find("offers")
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
      const item = event.target instanceof Element && event.target.closest("li")
      if (item) this.#take([...this.#list.children].indexOf(item))
    })
  }

  get open() {
    return !this.#list.hidden
  }

  /**
   * @param {Word[]} words
   * @param {{ left: number, top: number, bottom: number }} place of what is written already
   */
  show(words, place) {
    this.#list.replaceChildren(
      ...words.map(({ word, about }, i) => {
        const item = document.createElement("li")
        item.id = `offer-${i}`
        item.role = "option"
        item.ariaSelected = "false"
        const name = document.createElement("b")
        name.textContent = word
        const detail = document.createElement("span")
        detail.textContent = about
        item.append(name, " ", detail)
        return item
      }),
    )
    this.#list.hidden = false
    this.#chosen = -1
    this.#owner.removeAttribute("aria-activedescendant")
    beside(this.#list, place)
  }

  /**
   * Has words be tapped.
   * @param {Word[]} words
   * @param {string} begun what is written already; if that is nothing, the words that are always there are left out
   */
  tap(words, begun) {
    const offered = words.map(({ word }) => word).filter((word) => begun || !WORDS.includes(word))
    offerToTap(offered, (word) => {
      this.hide()
      this.#pick(word)
    })
  }

  /** @param {{ left: number, top: number, bottom: number }} place of what is written already, now */
  move(place) {
    beside(this.#list, place)
  }

  hide() {
    this.tap([], "")
    this.#list.hidden = true
    this.#owner.removeAttribute("aria-activedescendant")
  }

  /** Whether a key was for the list. @param {KeyboardEvent} event */
  takes({ key, shiftKey }) {
    if (!this.open || shiftKey) return false
    if (key === "ArrowDown" || key === "ArrowUp") this.#choose(key === "ArrowDown" ? 1 : -1)
    else if (key === "Escape") this.hide()
    else if (key === "Tab") this.#take(Math.max(this.#chosen, 0))
    else if (key === "Enter" && this.#chosen >= 0) this.#take(this.#chosen)
    else return false
    return true
  }

  /** @param {number} step */
  #choose(step) {
    const items = [...this.#list.children]
    const from = this.#chosen < 0 && step < 0 ? 0 : this.#chosen
    this.#chosen = (from + step + items.length) % items.length
    items.forEach((item, i) => (item.ariaSelected = String(i === this.#chosen)))
    items[this.#chosen].scrollIntoView({ block: "nearest" })
    this.#owner.setAttribute("aria-activedescendant", items[this.#chosen].id)
  }

  /** @param {number} index */
  #take(index) {
    const word = this.#list.children[index]?.querySelector("b")?.textContent
    this.hide()
    if (word) this.#pick(word)
  }
}

/**
 * Puts a box below a place, or above it if there is no room.
 * @param {HTMLElement} box
 * @param {{ left: number, top: number, bottom: number }} place
 */
export function beside(box, { left, top, bottom }) {
  const { width, height } = box.getBoundingClientRect()
  box.style.left = `${Math.max(4, Math.min(left, innerWidth - width - 4))}px`
  box.style.top = `${bottom + height + 4 < innerHeight || top < height + 4 ? bottom + 4 : top - height - 4}px`
}
