// @ts-check
// A tempo from taps. Pure.

export const MIN_TAPS = 8 // taps
const MAX_TAPS = 32
const MAX_GAP = 2.5 // seconds after which taps start over
const [SLOWEST, FASTEST] = [20, 400] // beats a minute

/** The taps that count after another one, in seconds. @param {number[]} taps @param {number} now */
export function tapped(taps, now) {
  const last = taps.at(-1)
  return [...(last !== undefined && now - last > MAX_GAP ? [] : taps), now].slice(-MAX_TAPS)
}

/**
 * The tempo of taps, in whole beats a minute; null if there are too few. It is the line that fits them best, so one tap
 * that is late changes little.
 * @param {number[]} taps
 */
export function tempoOf(taps) {
  if (taps.length < MIN_TAPS) return null
  const middle = (taps.length - 1) / 2
  const mean = taps.reduce((sum, tap) => sum + tap, 0) / taps.length
  const along = taps.reduce((sum, tap, index) => sum + (index - middle) * (tap - mean), 0)
  const across = taps.reduce((sum, _, index) => sum + (index - middle) ** 2, 0)
  return Math.min(Math.max(Math.round((60 * across) / along), SLOWEST), FASTEST)
}
