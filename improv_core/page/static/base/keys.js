// @ts-check
// The keyboard. Space stops the robots wherever the focus is, unless text is written there, and so does Escape unless
// something is open: then it closes that. Other keys work only where a person has put the focus on the stage or a control, so that
// a text that is typed into the wrong window starts nothing.

const CONTROLS = "#stage, #bar, #tools, #presenting, #senses, #timeline, .card"

/**
 * @typedef {object} Actions
 * @property {(event: KeyboardEvent) => void} stop for Space and Escape
 * @property {(key: string) => (() => string | void) | undefined} actionOf a key; each action returns what it did, in a word or two
 * @property {Record<string, () => void>} shifted arrows with Shift
 * @property {() => boolean} lettersWork
 * @property {(line: string) => void} say shows what a letter did, or why it did nothing
 */

/** True if a card, another dialog, or the tools are open: Escape closes them first, wherever the focus is. */
export const isOpen = () => document.querySelector("dialog[open], #show-more[aria-expanded=true]") !== null

/** Calls functions for keys. @param {Actions} actions */
export function listen({ stop, actionOf, shifted, lettersWork, say }) {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing || event.defaultPrevented) return
    const target = event.target instanceof Element ? event.target : document.body
    if (event.code === "Space" && target.closest("textarea, input[type=text]")) return
    if (event.code === "Space" || event.key === "Escape") {
      event.preventDefault() // otherwise Space would also press the focused button
      if (!event.repeat) stop(event)
      return
    }
    if (target.closest("input, select, textarea, .toml-lines pre")) return
    const arrow = event.key.startsWith("Arrow")
    const letter = event.key.length === 1
    const action = arrow && event.shiftKey ? shifted[event.key] : actionOf(keyOf(event))
    if (!action || (letter && !lettersWork())) return
    if (!target.closest(CONTROLS)) {
      if (letter && target === document.body) say("Keys work once you have clicked the stage")
      return
    }
    if (event.repeat && !arrow && !"+-".includes(event.key)) return
    event.preventDefault()
    const done = action()
    if (letter && done) say(`${keyOf(event).toUpperCase()}: ${done}`)
  })
}

/**
 * The key that is pressed, whether Caps Lock is on or not. On a keyboard without Latin letters, it is the one at the
 * same place of a keyboard with them.
 * @param {Pick<KeyboardEvent, "key" | "code">} event
 */
export function keyOf({ key, code }) {
  if (key.length > 1) return key
  const other = { BracketLeft: "[", BracketRight: "]" }[code] ?? /^Key([A-Z])$/.exec(code)?.[1]
  return (key > "\u024F" && other ? other : key).toLowerCase()
}
