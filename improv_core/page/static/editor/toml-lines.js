// @ts-check
// Lines for improv.toml that somebody may copy, where nobody can write them.

import { find } from "../base/elements.js"

/**
 * Returns a function that shows lines, or nothing if there are none.
 * @param {string} id of the element; those in it have this id with `-lines` and `-copy` after it
 */
export function tomlLines(id) {
  const [lines, button] = [find(`${id}-lines`), find(`${id}-copy`)]
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(lines.textContent ?? "")
      button.textContent = "Copied"
    } catch {
      getSelection()?.selectAllChildren(lines) // the browser forbids copying: ready for Ctrl+C
      button.textContent = "Selected"
    }
    setTimeout(() => (button.textContent = "Copy"), 1500)
  })
  return (/** @type {string} */ text) => {
    find(id).hidden = !text
    lines.textContent = text
  }
}
