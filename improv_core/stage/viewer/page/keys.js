// @ts-check
// The keyboard. Space stops the robots wherever the focus is, unless a program is written there, and so does Escape
// unless it closes something; other keys do nothing in input fields.

/**
 * Calls functions for keys: `keys` by `event.key`, `stop` for Space and Escape, `shifted` for arrows with Shift.
 * @param {(event: KeyboardEvent) => void} stop
 * @param {Record<string, () => void>} keys
 * @param {Record<string, () => void>} shifted
 * @param {() => boolean} lettersWork
 */
export function listen(stop, keys, shifted, lettersWork) {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing || event.defaultPrevented) return
    const target = event.target instanceof Element ? event.target : document.body
    if (event.code === "Space" && target.closest("textarea")) return
    if (event.code === "Space" || event.key === "Escape") {
      event.preventDefault() // otherwise Space would also press the focused button
      if (!event.repeat) stop(event)
      return
    }
    if (target.closest("input, select, textarea")) return
    const arrow = event.key.startsWith("Arrow")
    const action = arrow && event.shiftKey ? shifted[event.key] : keys[event.key.length === 1 ? event.key.toLowerCase() : event.key]
    if (!action || (event.key.length === 1 && !lettersWork())) return
    if (arrow && !event.shiftKey && target.closest("#score-text, .offer pre")) return // the arrows scroll there
    if (event.repeat && !arrow && !"+-".includes(event.key)) return
    event.preventDefault()
    action()
  })
}

/** Settings that last, if the browser stores them. */
export const settings = {
  /**
   * @param {string} name
   * @param {unknown} otherwise
   */
  get(name, otherwise) {
    try {
      return JSON.parse(localStorage.getItem(`improv.${name}`) ?? "null") ?? otherwise
    } catch {
      return otherwise
    }
  },
  /**
   * @param {string} name
   * @param {unknown} value
   */
  set(name, value) {
    try {
      localStorage.setItem(`improv.${name}`, JSON.stringify(value))
    } catch {
      // it lasts until the page is closed
    }
  },
}
