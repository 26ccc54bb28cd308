// @ts-check
// A row of words above the keyboard of a phone or tablet, on which brackets and dollar signs are hard to find.

import { find } from "./elements.js"

const WORDS = ["forward", "left", "right", "backward", "repeat", "(", ")", "[", "]", "$", "||", "=", "rest", "fast", "slow"]

export class WordRow {
  /** @param {HTMLTextAreaElement} control gets the words, as if they had been typed */
  constructor(control) {
    const row = find("word-row")
    row.replaceChildren(
      ...WORDS.map((word) => {
        const button = document.createElement("button")
        button.type = "button"
        button.textContent = word
        return button
      }),
    )
    row.addEventListener("pointerdown", (event) => event.preventDefault()) // the keyboard stays
    row.addEventListener("click", ({ target }) => {
      if (!(target instanceof HTMLButtonElement)) return
      control.focus()
      document.execCommand("insertText", false, spaced(control.value, control.selectionStart, target.textContent ?? ""))
    })
  }
}

/**
 * What to type for a word at an offset of a text: it is set apart from the words beside it.
 * @param {string} text
 * @param {number} offset
 * @param {string} word
 */
export function spaced(text, offset, word) {
  const before = text.slice(0, offset)
  const closes = word === ")" || word === "]"
  const apart = !closes && before !== "" && !/[\s([]$/.test(before)
  const opens = word === "(" || word === "["
  return `${apart ? " " : ""}${word}${opens ? "" : " "}`
}
