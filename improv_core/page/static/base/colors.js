// @ts-check
// The colors of the present theme, from the style sheet, for drawing on a canvas.

/** @typedef {ReturnType<typeof readColors>} Colors */

const NAMES = /** @type {const} */ ([
  "ground", "panel", "grid", "grid-strong", "ink", "quiet", "shadow", "below", "bump", "wall",
])

/** @type {Colors | null} */
let present = null

/** The colors of the present theme by their names in the style sheet, and `robots`, a list of them. */
export function colors() {
  return (present ??= readColors())
}

/** Has the colors read again: there is another theme. */
export function forgetColors() {
  present = null
}

/** The color of the robot with this index in the list of robots. @param {number} index */
export function robotColor(index) {
  const { robots } = colors()
  return robots[index % robots.length]
}

function readColors() {
  const style = getComputedStyle(document.documentElement)
  const read = (/** @type {string} */ name) => style.getPropertyValue(`--${name}`).trim()
  const colors = /** @type {Record<typeof NAMES[number], string>} */ (
    Object.fromEntries(NAMES.map((name) => [name, read(name)]))
  )
  return { ...colors, robots: read("robots").split(/\s+/) }
}

/**
 * The color `part` of the way from one #rrggbb to another, as #rrggbb.
 * @param {string} from
 * @param {string} to
 * @param {number} part
 */
export function mix(from, to, part) {
  const channel = (/** @type {string} */ color, /** @type {number} */ i) => parseInt(color.slice(1 + 2 * i, 3 + 2 * i), 16)
  const mixed = [0, 1, 2].map((i) => Math.round(channel(from, i) + (channel(to, i) - channel(from, i)) * part))
  return `#${mixed.map((value) => value.toString(16).padStart(2, "0")).join("")}`
}
