// @ts-check
// The place in a song where a grain joins best with the one before it: where the sound is most alike.

const OVERLAP = 0.012 // seconds that are compared
const REACH = 0.005 // seconds around the wanted position
const COARSE = 4 // samples from one try to the next, until the best is found

/**
 * The position near `wanted` from which the sound is most like the one from `from` on, in seconds.
 * @param {Float32Array} samples
 * @param {number} perSecond
 * @param {number} from
 * @param {number} wanted
 */
export function align(samples, perSecond, from, wanted) {
  const length = Math.round(OVERLAP * perSecond)
  const reach = Math.round(REACH * perSecond)
  const before = Math.round(from * perSecond)
  const at = Math.round(wanted * perSecond)
  if (before < 0 || before + length > samples.length) return wanted
  let best = at
  let most = -Infinity
  /** @param {number} start @param {number} step */
  const attempt = (start, step) => {
    if (start < 0 || start + length > samples.length) return
    const alike = likeness(samples, before, start, length, step)
    if (alike > most) [best, most] = [start, alike]
  }
  attempt(at, COARSE)
  for (let start = at - reach; start <= at + reach; start += COARSE) attempt(start, COARSE)
  most = -Infinity
  const middle = best
  attempt(middle, 1)
  for (let start = middle - COARSE + 1; start < middle + COARSE; start++) attempt(start, 1)
  return best / perSecond
}

/**
 * The similarity of the sound in two places, from -1 to 1.
 * @param {Float32Array} samples
 * @param {number} one
 * @param {number} two
 * @param {number} length
 * @param {number} step
 */
function likeness(samples, one, two, length, step) {
  let [both, first, second] = [0, 0, 0]
  for (let i = 0; i < length; i += step) {
    const [left, right] = [samples[one + i], samples[two + i]]
    both += left * right
    first += left * left
    second += right * right
  }
  return both / (Math.sqrt(first * second) || 1)
}
