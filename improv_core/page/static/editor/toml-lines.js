// @ts-check
// Lines for improv.toml that somebody may copy, where nobody can write them.

import { button, element, find } from "../base/elements.js"

/** Returns a function that shows lines, or nothing if there are none. @param {string} id of the element that gets them */
export function tomlLines(id) {
  const lines = element("pre", { id: `${id}-lines`, tabIndex: 0, ariaLabel: "Lines to copy" })
  const copy = button({ textContent: "Copy" }, async () => {
    try {
      await navigator.clipboard.writeText(lines.textContent ?? "")
      copy.textContent = "Copied"
    } catch {
      getSelection()?.selectAllChildren(lines) // the browser forbids copying: ready for Ctrl+C
      copy.textContent = "Selected"
    }
    setTimeout(() => (copy.textContent = "Copy"), 1500)
  })
  find(id).append(lines, element("p", { className: "row" }, copy))
  return (/** @type {string} */ text) => {
    find(id).hidden = !text
    lines.textContent = text
  }
}
