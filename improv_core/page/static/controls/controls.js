// @ts-check
// The bar: the dance that plays, and the buttons that control it.

import { countIn } from "../score/clock.js"
import { find } from "../base/elements.js"
import { LIMITS } from "../net/requests.js"

/** @import { Clock } from "../score/clock.js" */
/** @import { Messages } from "../net/messages.js" */
/** @import { Request } from "../net/requests.js" */
/** @import { Connection } from "../base/notices.js" */

const [SLOWEST, FASTEST] = LIMITS.speed.factor
const SPEEDS = [SLOWEST, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3, FASTEST]
const STEP_WINDOW = 2000 // milliseconds in which another step starts from the target of the last one, unless the server has confirmed it
const NO_TARGET = { beat: 0, at: -Infinity }

export class Controls {
  #clock
  #send
  /** @type {Messages["armed"] | null} */
  #armed = null // everything is ready, and waits for a person or a time
  #target = NO_TARGET // of the last seek, until the server confirms it
  /** @type {(() => boolean) | null} */
  writes = null // saves and plays the text on this page, if there is one that does not play; whether it did

  /**
   * `send` asks the server for something.
   * @param {Clock} clock
   * @param {(request: Request) => void} send
   */
  constructor(clock, send) {
    this.#clock = clock
    this.#send = send
    const press = {
      stop: () => this.stop(),
      play: () => this.playOrPause(),
      restart: () => this.restart(),
      step: () => this.step(),
      slower: () => this.slower(),
      faster: () => this.faster(),
    }
    for (const [id, action] of Object.entries(press)) find(id).addEventListener("click", action)
    find("normal").addEventListener("click", () => this.#send({ type: "speed", factor: 1 }))
  }

  /** @param {Messages["armed"]} message */
  takeArmed(message) {
    this.#armed = message.armed ? message : null
  }

  stop() {
    this.#send({ type: "stop" })
  }

  /** Plays or pauses. Returns what it did, if anything, as for every action of a key. */
  playOrPause() {
    const { state, generation } = this.#clock.transport
    if (this.#armed) {
      this.#send({ type: "resume" })
      return "begin"
    }
    if (state !== "playing" && this.writes?.()) return "save and play"
    if (!generation || state === "waiting") return
    if (state === "playing") this.#send({ type: "pause" })
    else this.#send({ type: state === "paused" ? "resume" : "restart" })
    return state === "playing" ? "pause" : "play"
  }

  restart() {
    if (!this.#clock.transport.generation) return
    this.#send({ type: "restart" })
    return "restart"
  }

  /** Pauses at the next whole beat. */
  step() {
    if (!this.#clock.transport.generation) return
    if (this.#clock.playing) this.#send({ type: "pause" })
    this.seekBy(1)
    return "next beat"
  }

  /**
   * Seeks to the next whole beat, or the one before.
   * @param {number} beats
   */
  seekBy(beats) {
    const now = performance.now()
    const beat = now - this.#target.at < STEP_WINDOW && !this.#clock.playing ? this.#target.beat : this.#clock.beat()
    this.seek(beats > 0 ? Math.floor(beat + 1e-6) + beats : Math.ceil(beat - 0.25) + beats)
  }

  /** @param {number} beat */
  seek(beat) {
    const { generation, beats } = this.#clock.transport
    if (!generation) return
    const target = Math.min(Math.max(beat, 0), beats ?? Infinity)
    this.#target = { beat: target, at: performance.now() }
    this.#send({ type: "seek", beat: target })
  }

  slower() {
    return this.#setSpeed(SPEEDS.findLast((speed) => speed < this.#clock.transport.speed))
  }

  faster() {
    return this.#setSpeed(SPEEDS.find((speed) => speed > this.#clock.transport.speed))
  }

  /** @param {number | undefined} factor */
  #setSpeed(factor) {
    if (!factor) return
    this.#send({ type: "speed", factor })
    return `speed ${factor}×`
  }

  /**
   * Shows the transport, except for what changes by itself.
   * @param {Connection} connection
   */
  show(connection) {
    const open = connection === "open"
    const { generation, state, beat, beats, tempo, speed, backend } = this.#clock.transport
    if (beat === this.#target.beat) this.#target = NO_TARGET
    const played = generation > 0
    document.body.dataset.state = this.#armed ? "armed" : state
    const playing = state === "playing"
    const plays = playing ? "Pause" : this.#armed ? "Begin" : "Play"
    find("state-word").textContent = open || (connection === "over" && played) ? (this.#armed ? this.#armedWord() : played ? state : "ready") : "offline"
    find("beat").hidden = !played
    const { bar, lastBeat } = this.#clock
    const bars = whole(Math.ceil(lastBeat / (bar ?? 1)))
    find("beat-end").textContent = beats === null ? "· ∞" : bar ? `/ ${bars} ${bars === "1" ? "bar" : "bars"}` : `/ ${bars}`
    find("tempo").textContent = played ? `${round(tempo)} beats/min` : ""
    find("backend").textContent = backend ?? ""
    find("play").setAttribute("aria-label", plays)
    find("play").title = `${plays} (K)`
    find("normal").textContent = `${round(speed)}×`
    find("normal").setAttribute("aria-label", `Speed ${round(speed)}, back to normal`)
    find("stop").setAttribute("aria-disabled", String(!open && connection !== "lost")) // it is sent until it arrives
    for (const id of ["play", "restart", "step", "slower", "normal", "faster"]) {
      const ready = played || (id === "play" && (this.#armed !== null || this.writes !== null))
      const waits = id === "play" && state === "waiting" && !this.#armed
      find(id).setAttribute("aria-disabled", String(!open || !ready || waits))
    }
    document.title = open && (played || this.#armed) ? `${this.#armed ? "armed" : state} · Improv` : "Improv"
    this.showBeat()
  }

  /** While beats are counted before beat 0: shows which. */
  showCount() {
    const { number, passed } = countIn(this.#armed, this.#clock.now())
    if (!number) return
    find("state-word").textContent = this.#armedWord()
    find("beat-now").textContent = whole(number)
    find("lamp").style.setProperty("--pulse", (1 + 0.5 * (1 - passed) ** 3).toFixed(2))
  }

  #armedWord() {
    if (countIn(this.#armed, this.#clock.now()).number) return "count-in"
    const begins = this.#armed?.begins
    return begins ? `armed for ${new Date(1000 * begins).toLocaleTimeString()}` : "armed"
  }

  showBeat() {
    const beat = this.#clock.beat()
    const { beats } = this.#clock.transport
    const { bar, countedBeat } = this.#clock
    const text = whole(bar ? ((countedBeat - 1) % bar) + 1 : countedBeat)
    const inBar = bar ? whole(Math.ceil(countedBeat / bar)) : ""
    const changed = find("beat-now").textContent !== text || find("in-bar").dataset.bar !== inBar
    if (changed) {
      find("beat-now").textContent = text
      find("in-bar").dataset.bar = inBar
      find("in-bar").replaceChildren(...(inBar ? [part("quiet", "bar"), " ", part("count", inBar), ", "] : []))
    }
    const pulse = this.#clock.playing ? 1 + 0.5 * (1 - (beat % 1)) ** 3 : 1
    find("lamp").style.setProperty("--pulse", pulse.toFixed(2))
    find("progress").style.setProperty("--done", beats ? (beat / beats).toFixed(4) : "0")
    return changed
  }

  /** The state in words, for screen readers. */
  spoken() {
    const { state, tempo, beats, beat } = this.#clock.transport
    if (countIn(this.#armed, this.#clock.now()).number) return "count-in"
    if (this.#armed) return `${this.#armedWord()}: press Play to begin`
    if (state === "paused") return `paused at ${this.#clock.words}`
    if (state !== "playing") return state
    const from = beat > 0.5 ? ` from ${this.#clock.words}` : ""
    const length = beats === null ? "without end" : `${round(beats)} beats`
    return `playing${from} ${length} at ${round(tempo)} beats per minute`
  }
}

/**
 * @param {string} kind
 * @param {string} text
 */
function part(kind, text) {
  const element = document.createElement("span")
  element.className = kind
  element.textContent = text
  return element
}

/** @param {number} number */
function round(number) {
  return Number(number.toFixed(2))
}

/**
 * A whole number, kept short for dances longer than anybody will wait.
 * @param {number} number
 */
function whole(number) {
  return number < 1e6 ? String(number) : number.toExponential(0).replace("e+", "e")
}
