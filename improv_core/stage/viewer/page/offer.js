// @ts-check
// Lines for improv.toml that somebody may copy, or have the editor write. Nothing is written unless somebody asks.

const COPY = "To start there, copy these lines into improv.toml."
const PLAYS = "Robots start there when you next press Play or Restart. This is not kept: to keep it, copy these lines into improv.toml."

import { find } from "./elements.js"

export class Offer {
  #id
  #writes = false
  #plays = false

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
    this.#writes = possible
    this.#explain()
  }

  /** @param {boolean} possible whether robots start there without any file */
  set plays(possible) {
    this.#plays = possible
    this.#explain()
  }

  #explain() {
    find(`${this.#id}-write`).hidden = !this.#writes
    find(`${this.#id}-how`).hidden = this.#writes
    find(`${this.#id}-how`).textContent = this.#plays ? PLAYS : COPY
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
