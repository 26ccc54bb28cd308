// The timeline: one row per robot, an item per word as wide as it lasts, and the playhead. Drag it to scrub.

import { TimelineSheet } from "./timesheet.js"

const LEAST = 30 // pixels of a beat, at 16 pixels a letter: a longer score scrolls
const LEAD = 0.25 // where in the view the playhead stays
const CROWD = 16 // robots, whose rows are lower: the stage needs the room
const SENDING = 60 // milliseconds between two seeks while scrubbing

export class Timeline {
  #tracks
  #line
  #list
  #sheet
  #seek
  #silence
  #left = 0 // the beat at the left edge
  #scrubbed = null // the beat that the pointer asks for
  #sent = 0
  #drawn = ""
  #scale = 1 // pixels of a beat
  #sizes = { width: 0, height: 0, letter: 16, head: 0, row: 0 }
  #score = null
  #clock

  /** `seek(beat)` and `silence(muted, soloed)` say what somebody asks for. */
  constructor(clock, seek, silence) {
    this.#clock = clock
    this.#seek = seek
    this.#silence = silence
    this.#tracks = document.getElementById("tracks")
    this.#line = document.getElementById("playline")
    this.#list = document.getElementById("cast-list")
    this.#sheet = new TimelineSheet(document.getElementById("rows"))
    this.#line.addEventListener("pointerdown", (event) => this.#press(event))
    this.#line.addEventListener("pointermove", (event) => this.#drag(event))
    for (const end of ["pointerup", "pointercancel"]) this.#line.addEventListener(end, () => this.#release())
    this.#tracks.addEventListener("scroll", () => this.touch())
  }

  /** Has the next frame draw everything anew. */
  touch() {
    this.#drawn = ""
    this.#sheet.forget()
  }

  set colors(colors) {
    this.#sheet.colors = colors
  }

  resize() {
    this.#sizes = {
      width: this.#line.clientWidth,
      height: this.#tracks.clientHeight,
      letter: parseFloat(getComputedStyle(this.#tracks).fontSize),
      head: document.getElementById("cast-head").offsetHeight,
      row: this.#list.firstElementChild?.getBoundingClientRect().height ?? 0,
    }
    this.#sheet.resize(this.#sizes.width, this.#sizes.height)
    this.touch()
  }

  /** Shows another score; `cast` are robots with their names and colors. */
  show(score, cast) {
    this.#score = score
    this.#left = 0
    this.#tracks.classList.toggle("crowd", cast.length > CROWD)
    this.#sheet.show(score, cast)
    this.#list.replaceChildren(...cast.map((robot) => this.#row(robot)))
    this.showSilence()
    this.showPosition()
    this.resize()
  }

  /** Shows who is muted and who plays solo. */
  showSilence() {
    const { muted, soloed } = this.#clock.transport
    for (const row of this.#list.children) {
      const { robot } = row.dataset
      row.dataset.silent = this.#clock.isSilent(robot)
      row.querySelector(".mute").setAttribute("aria-pressed", muted.includes(robot))
      row.querySelector(".solo").setAttribute("aria-pressed", soloed.includes(robot))
    }
    this.touch()
  }

  /** Tells the position to those who do not see it. */
  showPosition() {
    const { beats } = this.#clock.transport
    const beat = this.#scrubbed ?? this.#clock.beat()
    const values = {
      "aria-valuenow": Number(beat.toFixed(2)),
      "aria-valuemax": beats ?? Math.ceil(beat) + 1,
      "aria-valuetext": `beat ${this.#clock.countedBeat}${beats === null ? ", endless" : ` of ${this.#clock.lastBeat}`}`,
    }
    for (const [name, value] of Object.entries(values)) this.#line.setAttribute(name, value)
  }

  draw(outlook, still) {
    const { width, height } = this.#sizes
    if (!this.#score || !width || height < 2) return
    const { letter } = this.#sizes
    const least = (LEAST * letter) / 16
    const beat = this.#scrubbed ?? this.#clock.beat()
    const beats = this.#score.beats ?? Infinity
    const fits = beats * least <= width
    const scale = fits ? (width - 2) / Math.max(beats, 1) : least * 1.5
    const shown = width / scale
    if (fits) this.#left = 0
    else if (this.#scrubbed === null) this.#left = this.#follow(beat, shown, still)
    // In whole pixels: between them the sheet would be copied slowly, and nothing new be seen.
    const pixels = scale * Math.min(devicePixelRatio, 2)
    const left = Math.round(this.#left * pixels) / pixels
    const playhead = Math.round((beat - left) * pixels)
    const look = [playhead, left, scale, outlook?.version, this.#clock.transport.state].join()
    if (look === this.#drawn) return
    this.#drawn = look
    this.#sheet.draw({
      outlook,
      beat,
      left,
      scale,
      ...this.#sizes,
      top: this.#tracks.scrollTop,
      lit: ["playing", "paused"].includes(this.#clock.transport.state),
      silent: (robot) => this.#clock.isSilent(robot),
    })
    this.#scale = scale
  }

  #follow(beat, shown, still) {
    const wanted = Math.max(beat - shown * LEAD, 0)
    if (this.#clock.playing && !still) return wanted
    if (beat < this.#left || beat > this.#left + shown * 0.9) return Math.max(beat - shown * 0.1, 0) // turns the page
    return this.#left
  }

  #row({ name, color }) {
    const row = document.createElement("li")
    row.dataset.robot = name
    row.style.setProperty("--robot", color)
    const dot = document.createElement("span")
    dot.className = "dot"
    const label = document.createElement("span")
    label.className = "name"
    label.textContent = name
    row.append(dot, label)
    if (this.#score.robots[name]?.beats === null) {
      const endless = document.createElement("span")
      Object.assign(endless, { className: "endless", textContent: "∞", title: "goes on without end" })
      row.append(endless)
    }
    row.append(this.#button("mute", "Mute", name), this.#button("solo", "Solo", name))
    return row
  }

  #button(kind, word, name) {
    const button = document.createElement("button")
    button.type = "button"
    button.className = kind
    button.textContent = word[0]
    button.title = `${word} ${name}`
    button.setAttribute("aria-label", `${word} ${name}`)
    button.addEventListener("click", () => {
      const { muted, soloed } = this.#clock.transport
      const flip = (names) => (names.includes(name) ? names.filter((each) => each !== name) : [...names, name])
      if (kind === "mute") this.#silence(flip(muted), soloed)
      else this.#silence(muted, flip(soloed))
    })
    return button
  }

  #press(event) {
    if (event.button !== 0 || !this.#score) return
    this.#line.setPointerCapture(event.pointerId)
    this.#scrub(event, true)
  }

  #drag(event) {
    if (this.#scrubbed !== null) this.#scrub(event, performance.now() - this.#sent > SENDING)
  }

  #release() {
    if (this.#scrubbed === null) return
    this.#seek(this.#scrubbed)
    this.#scrubbed = null
  }

  #scrub(event, send) {
    const x = event.clientX - this.#line.getBoundingClientRect().left
    const beat = Math.max(this.#left + x / this.#scale, 0)
    this.#scrubbed = Number(Math.min(beat, this.#score.beats ?? Infinity).toFixed(3))
    if (!send) return
    this.#sent = performance.now()
    this.#seek(this.#scrubbed)
  }
}
