// @ts-check
// The meaning of the word below the pointer, in words and as a picture of its path.

import { element, find, svgAddress } from "../base/elements.js"
import { placeBeside } from "./completions.js"

const HOVER_DELAY = 300 // milliseconds for which the pointer rests before the page asks

export class Tooltip {
  #box = find("tooltip")
  #timer = 0
  /** @type {{ left: number, top: number, bottom: number } | null} */
  #place = null // of the word in the question

  /**
   * `ask` is called with the point at which the pointer rests; it returns whether there is anything to wait for.
   * @param {HTMLElement} owner
   * @param {(x: number, y: number) => boolean} ask
   */
  constructor(owner, ask) {
    owner.addEventListener("pointermove", ({ clientX: x, clientY: y, pointerType, buttons }) => {
      this.hide()
      if (pointerType !== "mouse" || buttons) return
      this.#timer = window.setTimeout(() => (this.#place = ask(x, y) ? { left: x, top: y - 12, bottom: y + 12 } : null), HOVER_DELAY)
    })
    for (const kind of ["pointerleave", "pointerdown", "wheel", "blur"]) {
      owner.addEventListener(kind, () => this.hide(), { passive: true })
    }
  }

  /** @param {string} text @param {string} picture SVG, or nothing */
  show(text, picture) {
    if (!this.#place) return
    this.#box.replaceChildren(element("p", { textContent: text }))
    if (picture) {
      const image = element("img", { alt: "", src: svgAddress(picture) })
      this.#box.append(image)
      const place = this.#place
      image.addEventListener("load", () => placeBeside(this.#box, place))
    }
    this.#box.hidden = false
    placeBeside(this.#box, this.#place)
  }

  hide() {
    clearTimeout(this.#timer)
    this.#place = null
    if (!this.#box.hidden) this.#box.hidden = true // with each key, browsers would compute styles
  }
}
