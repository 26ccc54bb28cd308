// @ts-check
// A row above the keyboard of a phone or tablet, which has no Ctrl+Z, and on which brackets and dollar signs are hard to
// find: Undo, then the words that fit here, then those that are always there.

import { element, find } from "../base/elements.js"

export const WORDS = ["forward", "left", "right", "backward", "repeat", "(", ")", "[", "]", "$", "||", "=", "rest", "fast", "slow"]

/** @param {HTMLTextAreaElement} control gets the words, as if they had been typed */
export function offerWords(control) {
  const always = find("word-always")
  always.replaceChildren(...WORDS.map((word) => wordButton(word)))
  find("word-row").addEventListener("pointerdown", (event) => event.preventDefault()) // the keyboard stays
  always.addEventListener("click", ({ target }) => {
    if (!(target instanceof HTMLButtonElement)) return
    control.focus()
    document.execCommand("insertText", false, spaced(control.value, control.selectionStart, target.textContent ?? ""))
  })
  find("undo").addEventListener("click", () => {
    const writes = document.activeElement === control
    control.focus()
    document.execCommand("undo")
    if (!writes) control.blur() // or the keyboard would come up
  })
}

/** @param {string} word */
export function wordButton(word) {
  return element("button", { type: "button", textContent: word })
}

/**
 * The text to insert for a word at an offset: with spaces between it and the words beside it.
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
