// What a stretch of a score looks like on the timeline: the words that play in it, by voice, and what holds them.

// Of each word that moves: its sign, the sign of its mirror image, and the velocity it makes.
const WORDS = {
  forward: ["↑", "↓", "x", 1],
  backward: ["↓", "↑", "x", -1],
  left: ["↰", "↱", "yaw", 1],
  right: ["↱", "↰", "yaw", -1],
  halfleft: ["↖", "↗", "yaw", 1],
  halfright: ["↗", "↖", "yaw", -1],
  strafeleft: ["←", "→", "y", 1],
  straferight: ["→", "←", "y", -1],
  up: ["⤒", "⤓", "z", 1],
  down: ["⤓", "⤒", "z", -1],
  rest: ["·", "·", "x", 0],
}

/** Reads a program's text by code points, as the server counts. */
export class Reader {
  #points
  #brackets = null
  #known = new WeakMap()

  constructor(text) {
    this.#points = Array.from(text)
  }

  word([start, end]) {
    return this.#points.slice(start, end).join("")
  }

  /**
   * The voices of a stretch, each its word, where that is, and the names it is used by. A stretch has for each voice
   * the names' places first, then the word of the language.
   */
  voices(stretch) {
    let voices = this.#known.get(stretch)
    if (!voices) {
      voices = []
      let names = []
      for (const span of stretch.words) {
        const word = this.word(span)
        if (Object.hasOwn(WORDS, word)) {
          voices.push({ word, sign: signOf(word, stretch.velocity), at: span[0], names })
          names = []
        } else names.push({ word, at: span[0] })
      }
      this.#known.set(stretch, voices)
    }
    return voices
  }

  /** Where the innermost `[` around a place begins, or undefined. */
  bracket(at) {
    this.#brackets ??= brackets(this.#points)
    return this.#brackets.get(at)
  }
}

/** The sign of what a word does here, where it may be reflected or retraced. */
function signOf(word, velocity) {
  const [sign, mirrored, axis, way] = WORDS[word]
  return velocity[axis] * way < 0 ? mirrored : sign
}

/** For the first place of each word within brackets, where the innermost one begins. */
function brackets(points) {
  const found = new Map()
  const open = []
  for (let i = 0; i < points.length; i++) {
    const sign = points[i]
    if (sign === "#") while (i + 1 < points.length && points[i + 1] !== "\n") i++
    else if (sign === "[") open.push(i)
    else if (sign === "]") open.pop()
    else if (open.length && !/\s/.test(sign)) found.set(i, open.at(-1))
  }
  return found
}

/**
 * Which stretches from index `first` up to `last` belong together: for each run with the same key (undefined: none)
 * its start, end and key. A run ends where its words begin anew, as in a repeat.
 */
export function runs(stretches, first, last, reader, keyOf) {
  const found = []
  let run = null
  for (let i = first; i < last; i++) {
    const voices = reader.voices(stretches[i])
    const key = voices.length ? keyOf(voices) : undefined
    const way = run && run.key === key ? direction(run.voices, voices) : 0
    if (key !== undefined && way !== 0 && (run.way === 0 || run.way === way)) {
      Object.assign(run, { end: stretches[i].end, voices, way })
    } else {
      run = key === undefined ? null : { key, start: stretches[i].start, end: stretches[i].end, voices, way: 0 }
      if (run) found.push(run)
    }
  }
  return found
}

/** 1 if voices go on in the text, -1 if they go back, 0 if neither: something else begins. */
export function direction(before, now) {
  if (before.length !== now.length) return 0
  const steps = now.map(({ at }, i) => Math.sign(at - before[i].at))
  if (steps.every((step) => step >= 0) && steps.includes(1)) return 1
  return steps.every((step) => step <= 0) && steps.includes(-1) ? -1 : 0
}

/**
 * The names that all voices are used by, from the outermost on. What is used by name and has voices itself tells its
 * names once, with the first of them.
 */
export function namesOf([first, ...others]) {
  return first.names.filter(({ at }, i) => others.every(({ names }) => !names.length || names[i]?.at === at))
}
