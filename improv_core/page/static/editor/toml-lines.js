// @ts-check
// Lines for improv.toml that somebody may copy, where nobody can write them.

import { find } from "../base/elements.js"

export class TomlLines {
  #id

  /**
   * The elements have this id, and `-lines` and `-copy` after it.
   * @param {string} id
   */
  constructor(id) {
    this.#id = id
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
