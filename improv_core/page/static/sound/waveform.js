// @ts-check
// The song under the timeline, with the lines of its beats. Dragged, or moved with arrow keys, it fits the beats.

import { colors } from "../base/colors.js"
import { find, findA } from "../base/elements.js"
import { refit, wake } from "../base/frames.js"
import { fillRect, penOn } from "../base/pen.js"
import { firstBeatAfter, loudness, rounded, shapeOf } from "./wave.js"

/** @import { Fit, Shape } from "./wave.js" */
/** @typedef {Fit & { bar: number | null }} Fitting */

const STEP = 0.01 // seconds that an arrow key moves it
const SILENT = 1 // pixels

export class Waveform {
  #canvas = findA("wave", HTMLCanvasElement)
  #line = find("song-line-up")
  #pen = penOn(this.#canvas, { alpha: false })
  #move
  #moved
  /** @type {Shape | null} */
  #shape = null
  /** @type {AudioBuffer | null} */
  #buffer = null
  /** @type {Fitting} */
  #fit = { firstBeat: 0, tempo: 60, bar: null }
  #scale = 1
  #drawn = ""
  /** @type {{ x: number, from: Fitting } | null} */
  #held = null

  /**
   * `move` has the song heard with beat 0 elsewhere, and `moved` has that written.
   * @param {(firstBeat: number) => void} move
   * @param {() => void} moved
   */
  constructor(move, moved) {
    this.#move = move
    this.#moved = moved
    this.#line.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return
      this.#line.setPointerCapture(event.pointerId)
      this.#held = { x: event.clientX, from: this.#fit }
    })
    this.#line.addEventListener("pointermove", (event) => {
      if (this.#held) this.#move(firstBeatAfter(this.#held.from, this.#scale, event.clientX - this.#held.x))
    })
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) this.#line.addEventListener(end, () => this.#release())
    this.#line.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: STEP, ArrowRight: -STEP }[event.key]
      if (!by || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return
      event.preventDefault() // otherwise it would go to another beat
      this.#move(rounded(this.#fit.firstBeat + by))
      this.#moved()
    })
  }

  /**
   * Shows a song, or none, and where its beats are.
   * @param {AudioBuffer | null} buffer
   * @param {string} name
   * @param {Fitting} fit
   */
  show(buffer, name, fit) {
    const changes = (buffer === null) !== (this.#buffer === null)
    if (buffer !== this.#buffer) this.#shape = buffer && shapeOf(buffer)
    this.#buffer = buffer
    this.#fit = fit
    find("song-head").hidden = this.#line.hidden = !buffer
    find("song-title").textContent = find("song-title").title = name
    find("song-first").textContent = `beat 1 at ${fit.firstBeat.toFixed(3)} s`
    this.#line.setAttribute("aria-valuenow", String(fit.firstBeat))
    this.#drawn = ""
    wake()
    if (changes) refit() // there is a row more, or less
  }

  /**
   * Draws the song below a stretch of the timeline, if anything has changed.
   * @param {{ left: number, scale: number, beat: number, width: number }} shown
   */
  draw({ left, scale, beat, width }) {
    if (!this.#shape || !width) return
    this.#scale = scale
    const ratio = Math.min(devicePixelRatio, 2)
    const height = this.#line.clientHeight
    const playhead = Math.round((beat - left) * scale)
    const look = [left, scale, playhead, width, height, ratio, colors().panel].join()
    if (look === this.#drawn) return
    this.#drawn = look
    this.#canvas.width = Math.round(width * ratio)
    this.#canvas.height = Math.round(height * ratio)
    const pen = this.#pen
    pen.setTransform(ratio, 0, 0, ratio, 0, 0)
    fillRect(pen, colors().panel, 0, 0, width, height)
    pen.fillStyle = colors()["grid-strong"]
    const step = this.#fit.bar ?? 1
    const every = step * 2 ** Math.max(Math.ceil(Math.log2(6 / (scale * step))), 0)
    for (let line = Math.ceil(left / every) * every; (line - left) * scale < width; line += every) {
      pen.fillRect(Math.round((line - left) * scale), 0, this.#fit.bar ? 2 : 1, height)
    }
    pen.fillStyle = colors().quiet
    for (const [x, loud] of loudness(this.#shape, this.#fit, { left, scale, width }).entries()) {
      const high = loud < 0 ? 0 : Math.max(loud * (height - 4), SILENT)
      if (high) pen.fillRect(x, (height - high) / 2, 1, high)
    }
    fillRect(pen, colors().ink, playhead - 1, 0, 2, height)
  }

  #release() {
    if (!this.#held) return
    const { from } = this.#held
    this.#held = null
    if (from.firstBeat !== this.#fit.firstBeat) this.#moved()
  }
}
