// @ts-check
// The work of the next frame: whatever changes what the stage shows, or what covers it, leaves a note here.

/** What the next frame has to do: draw the stage, and before that fit it to what covers it. */
export const due = { draw: true, fit: true }

/** Has the next frame draw the stage. */
export function redraw() {
  due.draw = true
}

/** Has the next frame fit the stage to what covers it, and draw it. */
export function refit() {
  due.draw = due.fit = true
}
