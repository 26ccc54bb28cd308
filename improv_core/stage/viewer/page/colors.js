// The colors of the present theme, read from the style sheet, for those who draw on a canvas.

/** The colors by their names in the style sheet, and `robots`, a list of them. */
export function readColors() {
  const style = getComputedStyle(document.documentElement)
  const read = (name) => style.getPropertyValue(`--${name}`).trim()
  const names = ["ground", "panel", "grid", "grid-strong", "ink", "quiet", "shadow", "below", "bump", "wall"]
  return {
    ...Object.fromEntries(names.map((name) => [name, read(name)])),
    robots: read("robots").split(/\s+/),
  }
}

/** The color `part` of the way from one #rrggbb to another, as #rrggbb. */
export function mix(from, to, part) {
  const channel = (color, i) => parseInt(color.slice(1 + 2 * i, 3 + 2 * i), 16)
  const mixed = [0, 1, 2].map((i) => Math.round(channel(from, i) + (channel(to, i) - channel(from, i)) * part))
  return `#${mixed.map((value) => value.toString(16).padStart(2, "0")).join("")}`
}
