// The page: takes the server's messages, moves the stage sixty times a second, and stops the robots.

import { connect } from "./connection.js"
import { Motion } from "./motion.js"
import { Stage } from "./stage.js"

const NOTICES = {
  lost: "disconnected, trying again…",
  refused: "This link has expired. Open the page again from your editor or terminal.",
}
const WORDS = { playing: "playing", waiting: "waiting", stopped: "stopped", ended: "finished" }

const find = (id) => document.getElementById(id)
const motion = new Motion()
const stage = new Stage(find("stage"))
const stillness = matchMedia("(prefers-reduced-motion: reduce)")

let transport = { generation: 0, state: "stopped", beat: 0, beats: 0, tempo: 60, wall: 0 }
let connection = "opening"
let radii = {}
let robots = {}
let frames = 0
let stale = true // something has changed since the last drawing
let drawn = 0

const send = connect(take, change)

function take(message) {
  if (message.type === "poses") motion.take(message, seconds())
  else if (message.type === "robots") takeRobots(message.robots)
  else if (message.type === "transport") takeTransport(message)
  stale = true
}

function takeRobots(cast) {
  radii = Object.fromEntries(Object.entries(cast).map(([name, robot]) => [name, robot.radius]))
  motion.keep(new Set(Object.keys(cast)))
  const names = Object.keys(cast).join(", ")
  find("stage").setAttribute("aria-label", `The stage, seen from above${names && `, with ${names}`}`)
}

function takeTransport(message) {
  const { generation, state } = transport
  transport = message
  if (message.generation !== generation) motion.forgetTrails(seconds(), (position() * 60) / message.tempo)
  if (message.generation !== generation || message.state !== state) announce(spoken())
  showTransport()
}

function change(now) {
  if (now === "open") motion.clear() // the ways gone meanwhile are not known
  if (now !== "open" || connection === "lost" || connection === "refused") {
    announce(NOTICES[now] ?? "connected again")
  }
  connection = now
  document.body.dataset.connection = now
  find("notice").hidden = !(now in NOTICES)
  find("notice").textContent = NOTICES[now] ?? ""
  find("stop").setAttribute("aria-disabled", String(now !== "open"))
  stale = true
  showTransport()
}

function spoken() {
  const { state, tempo, beats } = transport
  if (state !== "playing") return WORDS[state]
  return `playing ${beats === null ? "without end" : `${round(beats)} beats`} at ${round(tempo)} beats per minute`
}

function announce(text) {
  if (find("news").textContent !== text) find("news").textContent = text
}

function showTransport() {
  const { generation, state, beats, tempo, backend } = transport
  const played = generation > 0
  document.body.dataset.state = state
  find("state-word").textContent = connection === "open" ? (played ? WORDS[state] : "ready") : "offline"
  find("hint").hidden = played || connection !== "open"
  find("beat").hidden = !played
  find("beat-end").textContent = beats === null ? "· ∞" : `/ ${whole(lastBeat())}`
  find("tempo").textContent = played ? `${round(tempo)} beats/min` : ""
  find("backend").textContent = backend ?? ""
  document.title = played && connection === "open" ? `${WORDS[state]} · Improv` : "Improv"
  showBeat()
}

/** The position in beats at this moment. */
function position() {
  const { state, beat, beats, wall, tempo } = transport
  const gone = state === "playing" ? ((Date.now() / 1000 - wall) * tempo) / 60 : 0
  return Math.min(Math.max(beat + gone, 0), beats ?? Infinity)
}

/** The number of the last beat, counted from 1; a beat that has only begun counts. */
function lastBeat() {
  return transport.beats === null ? Infinity : Math.max(Math.ceil(transport.beats), 1)
}

function showBeat() {
  const beat = position()
  const { beats, state } = transport
  const text = whole(Math.min(Math.floor(beat) + 1, lastBeat()))
  if (find("beat-now").textContent !== text) find("beat-now").textContent = text
  const pulse = state === "playing" ? 1 + 0.5 * (1 - (beat % 1)) ** 3 : 1
  find("header").style.setProperty("--pulse", pulse.toFixed(3))
  find("header").style.setProperty("--done", beats ? (beat / beats).toFixed(5) : "0")
}

function frame() {
  frames++
  const now = seconds()
  if (transport.state === "playing" && connection === "open") showBeat()
  const present = motion.present(now)
  robots = present.robots
  if (stale || present.moving) {
    const ease = stillness.matches ? Infinity : Math.min(now - drawn, 0.1)
    stale = stage.draw({ ...present, radii, trails: motion.trails }, ease) || present.moving
  }
  drawn = now
  requestAnimationFrame(frame)
}

function resize() {
  const button = find("stop").getBoundingClientRect()
  const bottom = button.top > innerHeight / 2 ? innerHeight - button.top : 0
  stage.resize({ top: find("header").offsetHeight, bottom })
  stale = true
}

function seconds() {
  return performance.now() / 1000
}

function round(number) {
  return Number(number.toFixed(2))
}

/** A whole number, short also where a dance takes longer than anybody will wait. */
function whole(number) {
  return number < 1e6 ? String(number) : number.toExponential(0).replace("e+", "e")
}

function stop() {
  send({ type: "hush" })
}

find("stop").addEventListener("click", stop)
addEventListener("keydown", (event) => {
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return
  if (event.code !== "Space" && event.key !== "Escape") return
  event.preventDefault() // else Space would also press the button that has the focus
  stop()
})
new ResizeObserver(resize).observe(find("stage"))
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  stage.readTheme()
  stale = true
})

/** For tests: what the page knows and shows. */
window.improv = Object.freeze({
  get robots() {
    return structuredClone(robots)
  },
  get transport() {
    return structuredClone(transport)
  },
  get frames() {
    return frames
  },
  get connected() {
    return connection === "open"
  },
})

stage.readTheme()
resize()
requestAnimationFrame(frame)
