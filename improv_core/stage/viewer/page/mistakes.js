// @ts-check
// The list of what is wrong with the text, with fixes as buttons.

import { find } from "./elements.js"

/** @import { Edit, Span } from "./edits.js" */
/** @typedef {Span & { file: string, line: number, severity: string, message: string, fixes: { title: string, edits: Edit[] }[] }} Mistake */

const ORDER = ["error", "warning", "information", "hint"]
const SHOWN = 20

/**
 * Shows what is wrong. `go` is called to go to an offset, and `fix` to make edits.
 * @param {Mistake[]} mistakes
 * @param {(offset: number) => void} go
 * @param {(edits: Edit[]) => void} fix
 */
export function list(mistakes, go, fix) {
  const sorted = [...mistakes].sort((one, two) => ORDER.indexOf(one.severity) - ORDER.indexOf(two.severity))
  find("mistakes").hidden = !mistakes.length
  find("mistakes").replaceChildren(
    ...sorted.slice(0, SHOWN).map((mistake) => {
      const item = document.createElement("li")
      item.className = mistake.severity
      const where = mistake.file ? `${mistake.file}, line ${mistake.line}` : `line ${mistake.line}`
      if (mistake.file) item.append(Object.assign(document.createElement("b"), { textContent: where }))
      else item.append(button(where, "plain", () => go(mistake.start)))
      item.append(Object.assign(document.createElement("span"), { textContent: mistake.message }))
      for (const { title, edits } of mistake.fixes) item.append(button(title, "fix", () => fix(edits)))
      return item
    }),
  )
}

/**
 * @param {string} text
 * @param {string} kind
 * @param {() => void} press
 */
function button(text, kind, press) {
  const made = document.createElement("button")
  made.type = "button"
  made.className = kind
  made.textContent = text
  made.addEventListener("click", press)
  return made
}
