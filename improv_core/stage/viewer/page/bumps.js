// Bumps: where robots ran into each other or into what stands there, how often, and how that is told.

const KEPT = 200
const SHOWN = 0.9 // seconds
const PAUSE = 3 // seconds between two announcements, so that everything else can be heard too

export class Bumps {
  #coming = [] // those of which the time has yet to be shown
  #shown = [] // {x, y, since}
  #untold = []
  #told = -Infinity
  count = 0

  /** A new performance begins, or another program. */
  clear() {
    this.#coming = []
    this.#shown = []
    this.#untold = []
    this.count = 0
  }

  /** Takes in new ones; or all in the `past`, before the page was there: they only count. */
  take({ bumps, past }) {
    if (!past) this.#coming = [...this.#coming, ...bumps].slice(-KEPT)
    this.count += bumps.length
  }

  /** Those to be seen at `now`, in seconds of the page's clock, as the stage shows `at` seconds of performance. */
  show(at, now) {
    const begun = this.#coming.filter((bump) => bump.at <= at)
    if (begun.length) {
      this.#coming = this.#coming.filter((bump) => bump.at > at)
      this.#shown.push(...begun.map(({ x, y }) => ({ x, y, since: now })))
      this.#untold.push(...begun.map(({ robots }) => robots))
    }
    if (this.#shown.length) this.#shown = this.#shown.filter(({ since }) => now - since < SHOWN)
    return this.#shown.map(({ x, y, since }) => ({ x, y, age: (now - since) / SHOWN }))
  }

  /** What to say at `now`, or nothing. */
  news(now) {
    if (!this.#untold.length || now - this.#told < PAUSE) return ""
    const [count, latest] = [this.#untold.length, inWords(this.#untold.at(-1))]
    this.#untold = []
    this.#told = now
    return count === 1 ? latest : `${count} bumps, at last ${latest}`
  }
}

function inWords([one, other]) {
  return other ? `${one} and ${other} bumped into each other` : `${one} bumped into an obstacle`
}
