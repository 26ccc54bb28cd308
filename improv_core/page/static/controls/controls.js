// @ts-check
// The bar: the dance that plays, and the buttons that control it.

import { find, span } from "../base/elements.js"
import { notices } from "../base/notices.js"
import { isWebsite } from "../net/backend.js"
import { LIMITS } from "../net/limits.js"
import { send } from "../net/send.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { confirmSeek, seekBy } from "./seek.js"

const [SLOWEST, FASTEST] = LIMITS.speed.factor
const SPEEDS = [SLOWEST, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3, FASTEST]

/** Saves and plays the text on this page, if there is one that does not play. Returns whether it did. @type {{ writes: (() => boolean) | null }} */
export const editing = { writes: null }

find("stop").addEventListener("click", stop)

/** Stops all robots. */
export function stop() {
  send({ type: "stop" })
}

/** Plays or pauses. Returns what it did, if anything, as for every action of a key. */
export function playOrPause() {
  const { state, generation } = clock.transport
  if (clock.armed) {
    send({ type: "resume" })
    return "begin"
  }
  if (state !== "playing" && editing.writes?.()) return "save and play"
  if (!generation || state === "waiting") return
  if (state === "playing") send({ type: "pause" })
  else send({ type: state === "paused" ? "resume" : "restart" })
  return state === "playing" ? "pause" : "play"
}

/** Begins again. */
export function restart() {
  if (!clock.transport.generation) return
  send({ type: "restart" })
  return "restart"
}

/** Pauses at the next whole beat. */
export function step() {
  if (!clock.transport.generation) return
  if (clock.playing) send({ type: "pause" })
  seekBy(1)
  return "next beat"
}

/** Plays more slowly. */
export function slower() {
  return setSpeed(SPEEDS.findLast((speed) => speed < clock.transport.speed))
}

/** Plays faster. */
export function faster() {
  return setSpeed(SPEEDS.find((speed) => speed > clock.transport.speed))
}

/** @param {number | undefined} factor */
export function setSpeed(factor) {
  if (!factor) return
  send({ type: "speed", factor })
  return `speed ${factor}×`
}

/** Shows the transport, except for what changes by itself. */
export function showTransport() {
  const { connection, isOpen: open } = notices
  const { generation, state, beats, tempo, speed, backend } = clock.transport
  confirmSeek()
  const played = generation > 0
  document.body.dataset.state = clock.armed ? "armed" : state
  const playing = state === "playing"
  const plays = playing ? "Pause" : clock.armed ? "Begin" : "Play"
  const begun = clock.armed ? armedWord() : played ? state : "ready"
  const before = isWebsite ? "loading…" : "connecting…"
  find("state-word").textContent = open || (connection === "over" && played) ? begun : connection === "opening" ? before : "offline"
  find("beat").hidden = !played
  const { bar } = program
  const bars = whole(Math.ceil(clock.lastBeat / (bar ?? 1)))
  find("beat-end").textContent = beats === null ? "· ∞" : bar ? `/ ${bars} ${bars === "1" ? "bar" : "bars"}` : `/ ${bars}`
  find("tempo").textContent = played ? `${round(tempo)} beats/min` : ""
  find("backend").textContent = backend ?? ""
  find("play").setAttribute("aria-label", plays)
  find("play").title = `${plays} (K)`
  find("normal").textContent = `${round(speed)}×`
  find("normal").setAttribute("aria-label", `Speed ${round(speed)}, back to normal`)
  find("stop").setAttribute("aria-disabled", String(!open && connection !== "lost")) // it is sent until it arrives
  for (const id of ["play", "restart", "step", "slower", "normal", "faster"]) {
    const ready = played || (id === "play" && (clock.armed !== null || editing.writes !== null))
    const waits = id === "play" && state === "waiting" && !clock.armed
    find(id).setAttribute("aria-disabled", String(!open || !ready || waits))
  }
  document.title = open && (played || clock.armed) ? `${clock.armed ? "armed" : state} · Improv` : "Improv"
  showBeat()
}

/** While beats are counted before beat 0: shows which. */
export function showCount() {
  const { number, passed } = clock.counted
  if (!number) return
  find("state-word").textContent = armedWord()
  find("beat-now").textContent = whole(number)
  find("lamp").style.setProperty("--pulse", (1 + 0.5 * (1 - passed) ** 3).toFixed(2))
}

function armedWord() {
  if (clock.counted.number) return "count-in"
  const begins = clock.armed?.begins
  return begins ? `armed for ${new Date(1000 * begins).toLocaleTimeString()}` : "armed"
}

/** Shows the beat. Returns whether it is another one. */
export function showBeat() {
  const beat = clock.beat()
  const { beats } = clock.transport
  const { countedBeat } = clock
  const { bar } = program
  const text = whole(bar ? ((countedBeat - 1) % bar) + 1 : countedBeat)
  const inBar = bar ? whole(Math.ceil(countedBeat / bar)) : ""
  const changed = find("beat-now").textContent !== text || find("in-bar").dataset.bar !== inBar
  if (changed) {
    find("beat-now").textContent = text
    find("in-bar").dataset.bar = inBar
    find("in-bar").replaceChildren(...(inBar ? [span("quiet", "bar"), " ", span("count", inBar), ", "] : []))
  }
  const pulse = clock.playing ? 1 + 0.5 * (1 - (beat % 1)) ** 3 : 1
  find("lamp").style.setProperty("--pulse", pulse.toFixed(2))
  find("progress").style.setProperty("--done", beats ? (beat / beats).toFixed(4) : "0")
  return changed
}

/** The state in words, for screen readers. */
export function spoken() {
  const { state, tempo, beats, beat } = clock.transport
  if (clock.counted.number) return "count-in"
  if (clock.armed) return `${armedWord()}: press Play to begin`
  if (state === "paused") return `paused at ${program.position}`
  if (state !== "playing") return state
  const from = beat > 0.5 ? ` from ${program.position}` : ""
  const length = beats === null ? "without end" : `${round(beats)} beats`
  return `playing${from} ${length} at ${round(tempo)} beats per minute`
}

/** @param {number} number */
function round(number) {
  return Number(number.toFixed(2))
}

/** A whole number, kept short for dances longer than anybody will wait. @param {number} number */
function whole(number) {
  return number < 1e6 ? String(number) : number.toExponential(0).replace("e+", "e")
}
