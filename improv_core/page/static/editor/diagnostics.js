// @ts-check
// The list of what is wrong with the text: a row for each message, with its fixes as buttons.

import { button, element, find } from "../base/elements.js"

/** @import { Edit, Span } from "./edits.js" */
/** @typedef {{ title: string, kind: string, edits: Edit[] }} Fix those of one kind may be made together */
/** @typedef {Span & { file: string, line: number, severity: string, message: string, fixes: Fix[] }} Diagnostic */

const MAX_KINDS = 2

/**
 * Shows what is wrong. `go` is called to go to an offset, and `fix` to make edits.
 * @param {Diagnostic[]} diagnostics
 * @param {number} count how many there are, also those that are not listed
 * @param {string} text that they are about
 * @param {(offset: number) => void} go
 * @param {(edits: Edit[]) => void} fix
 */
export function listDiagnostics(diagnostics, count, text, go, fix) {
  const lines = text.split("\n")
  /** @param {Diagnostic} diagnostic @param {number} index */
  const row = ({ file, line, message, severity, start, fixes }, index) => {
    const where = file
      ? element("b", { className: "where", textContent: `${file}, line ${line}` })
      : button({ className: "where", textContent: `line ${line}` }, () => go(start))
    const source = file ? "" : lines[line - 1]?.trim()
    const details = element(
      "details",
      { open: count === 1 },
      element("summary", { className: "words", textContent: message }),
      ...(source ? [element("code", { className: "source", textContent: source })] : []),
      ...fixes.map(({ title, edits }) => button({ className: "fix", textContent: title }, () => fix(edits))),
    )
    const quick = fixes.slice(0, 1).map(({ title, edits }) => {
      return button({ className: "quick", textContent: "Fix", title, ariaLabel: `Fix: ${title}` }, () => fix(edits))
    })
    const item = element("li", { className: severity }, where, details, ...quick)
    reach(item, index === 0)
    return item
  }
  find("diagnostics").hidden = !diagnostics.length
  const all = diagnostics.length < count ? `The first ${diagnostics.length} of ${count} messages` : count === 1 ? "1 message" : `${count} messages`
  find("diagnostics-title").textContent = all
  const kinds = groupFixes(diagnostics).slice(0, MAX_KINDS)
  find("diagnostics-kinds").replaceChildren(
    ...kinds.map(({ title, edits, times }) => button({ className: "fix-all", textContent: `${title}: all ${times}` }, () => fix(edits))),
  )
  find("diagnostics-head").hidden = count < 2
  find("diagnostics-list").replaceChildren(...diagnostics.map(row))
}

/**
 * The kinds of fixes that can be made more than once, with all their edits, the most frequent first.
 * @param {Diagnostic[]} diagnostics
 */
export function groupFixes(diagnostics) {
  /** @type {Map<string, { title: string, edits: Edit[], times: number }>} */
  const kinds = new Map()
  const fixes = diagnostics.filter(({ file }) => !file).flatMap(({ fixes }) => fixes.filter(({ kind }) => kind))
  for (const { kind, title, edits } of fixes) {
    const known = kinds.get(kind) ?? { title, edits: [], times: 0 }
    if (known.edits.some((one) => edits.some((other) => one.start < other.end && other.start < one.end))) continue
    kinds.set(kind, { ...known, edits: [...known.edits, ...edits], times: known.times + 1 })
  }
  return [...kinds.values()]
    .filter(({ times }) => times > 1)
    .sort((one, other) => other.times - one.times)
    .map((kind) => ({ ...kind, edits: kind.edits.sort((one, other) => one.start - other.start) }))
}

/** Has the arrows go from row to row. Only one row is reached with Tab, so that what comes after the list is near. */
export function listenForArrows() {
  find("diagnostics-list").addEventListener("keydown", (event) => move(event))
}

/** @param {KeyboardEvent} event */
function move(event) {
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key]
  const control = event.target instanceof HTMLElement ? event.target : null
  const from = control?.closest("li")
  const to = step && (step > 0 ? from?.nextElementSibling : from?.previousElementSibling)
  if (!control || !from || !(to instanceof HTMLElement)) return
  event.preventDefault()
  const same = to.querySelector(`.${control.classList[0]}`) ?? to.querySelector(".words")
  reach(from, false)
  reach(to, true)
  if (same instanceof HTMLElement) same.focus()
}

/** @param {HTMLElement} item @param {boolean} reachable with Tab */
function reach(item, reachable) {
  for (const each of item.querySelectorAll("button, summary")) if (each instanceof HTMLElement) each.tabIndex = reachable ? 0 : -1
}
