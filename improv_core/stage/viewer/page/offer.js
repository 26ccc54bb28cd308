// @ts-check
// Lines for improv.toml that somebody may copy, or have the editor write. Nothing is written unless somebody asks.

import { find } from "./elements.js"

export class Offer {
  #id

  /**
   * The elements have this id, and `-lines`, `-copy`, and `-write` after it.
   * @param {string} id
   * @param {() => void} write
   */
  constructor(id, write) {
    this.#id = id
    find(`${id}-write`).addEventListener("click", write)
    find(`${id}-copy`).addEventListener("click", () => this.#copy())
  }

  /**
   * Shows lines, or nothing if there are none.
   * @param {string} lines
   */
  show(lines) {
    find(this.#id).hidden = !lines
    find(`${this.#id}-lines`).textContent = lines
  }

  /** @param {boolean} possible whether anybody takes what the page asks to write */
  set writes(possible) {
    find(`${this.#id}-write`).hidden = !possible
  }

  async #copy() {
    const button = find(`${this.#id}-copy`)
    const lines = find(`${this.#id}-lines`)
    try {
      await navigator.clipboard.writeText(lines.textContent ?? "")
      button.textContent = "Copied"
    } catch {
      getSelection()?.selectAllChildren(lines) // the browser forbids copying: ready for Ctrl+C
      button.textContent = "Selected"
    }
    setTimeout(() => (button.textContent = "Copy"), 1500)
  }
}
