// @ts-check
// Bumps: where robots ran into each other or into obstacles, how often, and how that is announced.

/** @typedef {Messages["bumps"]["bumps"][number]} Bump */

const MAX_BUMPS = 200
const SHOW_TIME = 0.9 // seconds
const ANNOUNCE_PERIOD = 3 // seconds between two announcements, so that other announcements get through

export class Bumps {
  /** @type {Bump[]} */
  #coming = [] // not shown yet
  /** @type {{ x: number, y: number, since: number }[]} */
  #shown = []
  /** @type {Bump[]} */
  #untold = []
  #told = -Infinity
  #count = 0
  #counter

  /** @param {HTMLElement} counter shows how many there were */
  constructor(counter) {
    this.#counter = counter
  }

  /** Forgets all bumps: another performance or program begins. */
  clear() {
    this.#coming = []
    this.#shown = []
    this.#untold = []
    this.#setCount(0)
  }

  /**
   * Takes new bumps; those of the `past`, before the page was opened, are only counted.
   * @param {Messages["bumps"]} message
   */
  take({ bumps, past }) {
    if (!past) this.#coming = [...this.#coming, ...bumps].slice(-MAX_BUMPS)
    this.#setCount(this.#count + bumps.length)
  }

  /** @param {number} count */
  #setCount(count) {
    this.#count = count
    this.#counter.hidden = !count
    this.#counter.textContent = count === 1 ? "1 bump" : `${count} bumps`
  }

  /**
   * The bumps to draw at `now`, in seconds of the page's clock, while the stage shows `at` seconds of performance.
   * @param {number} at
   * @param {number} now
   */
  show(at, now) {
    const begun = this.#coming.filter((bump) => bump.at <= at)
    if (begun.length) {
      this.#coming = this.#coming.filter((bump) => bump.at > at)
      this.#shown.push(...begun.map(({ x, y }) => ({ x, y, since: now })))
      this.#untold.push(...begun)
    }
    if (this.#shown.length) this.#shown = this.#shown.filter(({ since }) => now - since < SHOW_TIME)
    return this.#shown.map(({ x, y, since }) => ({ x, y, age: (now - since) / SHOW_TIME }))
  }

  /** The announcement at `now`, or nothing. @param {number} now @param {(robot: string) => string} label for people */
  news(now, label) {
    if (!this.#untold.length || now - this.#told < ANNOUNCE_PERIOD) return ""
    const [count, latest] = [this.#untold.length, inWords(this.#untold[this.#untold.length - 1], label)]
    this.#untold = []
    this.#told = now
    return count === 1 ? latest : `${count} bumps, most recently ${latest}`
  }
}

/** @param {Bump} bump @param {(robot: string) => string} label */
function inWords({ robots, thing }, label) {
  const [one, other] = robots.map(label)
  return other ? `${one} and ${other} bumped into each other` : `${one} bumped into ${thing}`
}
