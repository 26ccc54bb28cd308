// The keyboard. Space and Escape stop the robots wherever the focus is; the other keys leave fields alone.

/** Has keys call functions: `keys` by `event.key`, `stop` for Space and Escape, `shifted` for arrows with Shift. */
export function listen(stop, keys, shifted, lettersWork) {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return
    if (event.code === "Space" || event.key === "Escape") {
      event.preventDefault() // else Space would also press the button that has the focus
      if (!event.repeat) stop(event)
      return
    }
    if (event.target.closest?.("input, select, textarea")) return
    const arrow = event.key.startsWith("Arrow")
    const action = arrow && event.shiftKey ? shifted[event.key] : keys[event.key.length === 1 ? event.key.toLowerCase() : event.key]
    if (!action || (event.key.length === 1 && !lettersWork())) return
    if (arrow && !event.shiftKey && event.target.closest?.("#score-text, #starts-lines")) return // they scroll
    if (event.repeat && !arrow && !"+-".includes(event.key)) return
    event.preventDefault()
    action()
  })
}

/** A setting that lasts, or not, where the browser keeps nothing for us. */
export const settings = {
  get(name, otherwise) {
    try {
      return JSON.parse(localStorage.getItem(`improv.${name}`)) ?? otherwise
    } catch {
      return otherwise
    }
  },
  set(name, value) {
    try {
      localStorage.setItem(`improv.${name}`, JSON.stringify(value))
    } catch {
      // it lasts as long as the page
    }
  },
}
