// The robots that a click mutes or solos.

/** @typedef {{ muted: string[], soloed: string[] }} Silenced */

/** Counts clicks that the stage has not answered yet: a request names all silent robots, so it must not forget them. */
export class Silence {
  /** @type {Silenced} */
  #told = { muted: [], soloed: [] }
  /** @type {Silenced[]} */
  #asked = [] // requests that no message has confirmed yet

  /** Takes in what a message says, which may be the answer to any of the requests. @param {Silenced} told */
  take(told) {
    this.#told = told
    const answered = this.#asked.findIndex((asked) => same(asked, told))
    this.#asked = answered < 0 ? [] : this.#asked.slice(answered + 1)
  }

  /** Returns what to ask for after a click on a robot's button. @param {keyof Silenced} kind @param {string} robot */
  flip(kind, robot) {
    const before = this.#asked.at(-1) ?? this.#told
    const names = before[kind]
    const after = names.includes(robot) ? names.filter((name) => name !== robot) : [...names, robot]
    const asked = { ...before, [kind]: after }
    this.#asked.push(asked)
    return asked
  }
}

/** @param {Silenced} one @param {Silenced} other */
function same(one, other) {
  const text = (/** @type {string[]} */ names) => [...names].sort().join()
  return text(one.muted) === text(other.muted) && text(one.soloed) === text(other.soloed)
}
