// The program's text, with the words lit that play now.

const COMMENT = /#.*/g
const WORD = /[^\s()[\]|#=$]+/gu
const BUILT_IN = /^(forward|backward|left|right|halfleft|halfright|rest|strafeleft|straferight|up|down)$/
const LONGEST = 200_000 // characters: beyond, a browser would take long to lay them out

export class Score {
  #text
  #words = new Map() // where a word begins, in code points -> its element
  #lit = new Map() // element -> color

  constructor(text) {
    this.#text = text
  }

  show(text) {
    this.#words.clear()
    this.#lit.clear()
    let at = 0 // in code points, as the server counts
    const lines = text.slice(0, LONGEST).split("\n")
    this.#text.replaceChildren(
      ...lines.map((line) => {
        const element = this.#line(line, at)
        at += Array.from(line).length + 1
        return element
      }),
    )
  }

  /** Lights the words at these places, a map of where they begin to the color of who plays them. */
  light(places) {
    const wanted = new Map()
    for (const [at, color] of places) {
      const word = this.#words.get(at)
      if (word) wanted.set(word, color)
    }
    for (const [word] of this.#lit) if (!wanted.has(word)) word.classList.remove("lit")
    for (const [word, color] of wanted) {
      if (this.#lit.get(word) === color) continue
      word.classList.add("lit")
      word.style.setProperty("--robot", color)
    }
    this.#lit = wanted
    this.#keepInView()
  }

  #line(line, start) {
    const element = document.createElement("div")
    const comment = line.search(COMMENT)
    const code = comment < 0 ? line : line.slice(0, comment)
    let done = 0
    for (const { 0: word, index } of code.matchAll(WORD)) {
      const span = document.createElement("span")
      span.textContent = word
      if (BUILT_IN.test(word)) span.className = "moving"
      element.append(code.slice(done, index), span)
      done = index + word.length
      this.#words.set(start + Array.from(code.slice(0, index)).length, span)
    }
    element.append(code.slice(done))
    if (comment >= 0) {
      const quiet = document.createElement("i")
      quiet.textContent = line.slice(comment)
      element.append(quiet)
    }
    if (!line) element.append("\u200b") // keeps an empty line's height
    return element
  }

  /** Scrolls only if nothing of what plays can be seen. */
  #keepInView() {
    const view = this.#text.getBoundingClientRect()
    if (!view.height || this.#text.scrollHeight <= this.#text.clientHeight) return
    let nearest = null
    for (const word of this.#lit.keys()) {
      const { top, bottom } = word.getBoundingClientRect()
      if (top >= view.top && bottom <= view.bottom) return
      nearest ??= word
    }
    if (nearest) this.#text.scrollTop += nearest.getBoundingClientRect().top - view.top - view.height / 3
  }
}

/** Lights words by the clock, in the color of who plays them; several robots share the color of the text. */
export class Lights {
  #score
  #clock
  #lit = ""

  constructor(score, clock) {
    this.#score = score
    this.#clock = clock
  }

  /** What was lit no longer counts: the text has changed, or the colors. */
  forget() {
    this.#lit = ""
  }

  /** Lights what plays at a beat; nothing where there is no outlook. */
  show(outlook, beat, colorOf, shared) {
    const places = new Map()
    const names = outlook ? Object.keys(outlook.score.robots) : []
    names.forEach((name, index) => {
      const stretch = !this.#clock.isSilent(name) && outlook.at(name, beat)
      if (!stretch || stretch.start > beat) return
      const color = colorOf(index)
      for (const [at] of stretch.words) places.set(at, (places.get(at) ?? color) === color ? color : shared)
    })
    const now = JSON.stringify([...places])
    if (now === this.#lit) return
    this.#lit = now
    this.#score.light(places)
  }
}
