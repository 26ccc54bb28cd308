// @ts-check
// Times as people read them.

/** A time of today, or a day with its time. @param {number} time in milliseconds since 1970 */
export function when(time) {
  const then = new Date(time)
  const today = then.toDateString() === new Date().toDateString()
  return then.toLocaleString([], { ...(today ? {} : { dateStyle: "medium" }), timeStyle: "short" })
}
