// The page: takes the server's messages, moves the stage sixty times a second, and asks for what people want.

import { Anchor } from "./anchor.js"
import { Bumps } from "./bumps.js"
import { bounds } from "./camera.js"
import { Clock } from "./clock.js"
import { connect } from "./connection.js"
import { Controls } from "./controls.js"
import { hold } from "./hands.js"
import { Motion } from "./motion.js"
import { Outlook } from "./outlook.js"
import { Panels } from "./panels.js"
import { Lights, Score } from "./score.js"
import { kindOf, Stage } from "./stage.js"
import { Starts } from "./starts.js"
import { fetchPicture } from "./takeaway.js"
import { Timeline } from "./timeline.js"
import { outline } from "./world.js"

const NOTICES = {
  lost: "disconnected, trying again…",
  refused: "This link has expired. Open the page again from your editor or terminal.",
  over: "The performance is over. Play again from your editor or terminal.",
}

const find = (id) => document.getElementById(id)
const seconds = () => performance.now() / 1000
const stillness = matchMedia("(prefers-reduced-motion: reduce)")
const clock = new Clock()
const motion = new Motion()
const anchor = new Anchor()
const bumps = new Bumps()
const stage = new Stage(find("stage"))
const score = new Score(find("score-text"))
const lights = new Lights(score, clock)
const controls = new Controls(clock, (message) => send(message))
const timeline = new Timeline(clock, (beat) => controls.seek(beat), (muted, soloed) => send({ type: "silence", muted, soloed }))
const starts = new Starts((message) => send(message), touch)

let connection = "opening"
let parting = "" // what the stage has said at its end
let radii = {}
let robots = {}
let outlook = null // of the score that plays
let next = null // of one that is to take over
let picture = null // a promise of its paths as SVG
let frames = 0
let stale = true // something has changed since the last drawing
let drawn = 0
let cleared = 0 // how often trails were
let pending = null // poses of which the ideal ones are not known yet
let known = "" // what is known of the ways, in short
let room = [] // corners of what the view should hold
let seen = false // whether there was a view that holds them

const panels = new Panels({ touch, resize, announce, getPicture, clearTrails, controls, camera: stage.camera, canvas: find("stage") })
const send = connect(take, change)

function take(message) {
  taking[message.type](message)
  stale = true
}

const taking = {
  poses: takePoses,
  robots: takeRobots,
  transport: takeTransport,
  score: takeScore,
  window: (message) => [outlook, next].forEach((each) => each?.take(message)),
  bumps: takeBumps,
  stopped: ({ message }) => (parting = message ? `The stage has failed: ${message}. Play again.` : NOTICES.over),
}

/** Poses come in the order of the robots. */
function takePoses({ at, placed, poses }) {
  const names = Object.keys(radii)
  if (names.length !== poses.length) return
  const anew = motion.take({ at, placed, poses: Object.fromEntries(names.map((name, index) => [name, poses[index]])) }, seconds())
  if (anew) clearBumps()
}

function takeBumps(message) {
  bumps.take(message)
  showBumps()
}

function clearBumps() {
  bumps.clear()
  showBumps()
}

function showBumps() {
  find("bumps").hidden = !bumps.count
  find("bumps").textContent = bumps.count === 1 ? "1 bump" : `${bumps.count} bumps`
}

function takeRobots({ robots: cast }) {
  radii = Object.fromEntries(Object.entries(cast).map(([name, robot]) => [name, robot.radius]))
  motion.keep(new Set(Object.keys(cast)))
  const names = Object.keys(cast).join(", ")
  find("stage").setAttribute("aria-label", `The stage, seen from above${names && `, with ${names}`}`)
}

function takeScore(message) {
  const coming = new Outlook(message, (from, to) => send({ type: "window", generation: message.generation, from, to }))
  if (message.generation === clock.transport.generation) show(coming)
  else next = coming
}

function takeTransport(message) {
  const { generation, state } = clock.transport
  const elsewhere = clock.take(message)
  if (message.generation !== generation) clearBumps()
  if (message.generation !== generation) motion.forgetTrails(message.performed - (message.beat * 60) / message.tempo)
  if (next?.score.generation === message.generation) show(next)
  if (elsewhere || message.state !== state) place(message)
  if (message.generation !== generation || message.state !== state) announce(controls.spoken())
  if (message.state === "ended" || message.state === "stopped") panels.finish()
  showTransport()
}

/** Shows another score. */
function show(coming) {
  outlook = coming
  next = picture = null
  score.show(outlook.score.text)
  find("dynamics").textContent = dynamics(Object.values(outlook.score.robots))
  lights.forget()
  anchor.clear()
  showCast()
}

function showCast() {
  if (!outlook) return
  const playing = cast().filter(({ name }) => Object.hasOwn(outlook.score.robots, name))
  timeline.show(outlook.score, playing)
  starts.show(outlook.score, playing)
}

/** Has the ways begin where the robots are. */
function place({ state, poses, beat }) {
  if (state === "stopped" || state === "ended" || state === "waiting") anchor.clear()
  else if (outlook && poses) pending = { poses, beat }
}

/** How the simulator moves its robots, in words: nobody should take an ideal for the world. */
function dynamics(robots) {
  const ideal = robots.filter((robot) => robot.dynamics === "ideal").length
  return ideal === robots.length ? "ideal motion" : ideal ? "some with motors" : "with motors"
}

function change(now) {
  if (now === "open") parting = ""
  if (now === "lost" && parting) now = "over"
  if (now === "open") {
    motion.clear() // the ways gone meanwhile are not known
    clearBumps()
    for (const each of [outlook, next]) each?.askAgain()
  }
  const notice = now === "over" ? parting : (NOTICES[now] ?? "")
  if (notice || connection !== "opening") announce(notice || "connected again")
  connection = now
  document.body.dataset.connection = now
  find("notice").hidden = !notice
  find("notice").textContent = notice
  touch()
  showTransport()
}

function showTransport() {
  controls.show(connection)
  find("next").hidden = !next || connection !== "open" || !clock.playing
  timeline.showSilence()
  timeline.showPosition()
}

function announce(text) {
  if (find("news").textContent !== text) find("news").textContent = text
}

function clearTrails() {
  motion.clearTrails()
  cleared++
  touch()
}

function touch() {
  stale = true
}

/** The robots in the order of the score, then others that are still there. */
function cast() {
  const about = outlook?.score.robots ?? {}
  return [...new Set([...Object.keys(about), ...Object.keys(radii)])].map((name, index) => ({
    name,
    color: stage.color(index),
    kind: kindOf(about[name]?.profile ?? "", about[name]?.motions),
    radius: radii[name] ?? about[name]?.radius ?? 0.3,
    way: outlook?.robots.get(name)?.[0]?.pose ? outlook.robots.get(name) : null,
  }))
}

/** The paths as SVG; a page keeps them for when the stage is gone. */
async function getPicture() {
  return (await picture) ?? (picture = fetchPicture())
}

function frame() {
  frames++
  const now = seconds()
  const open = connection === "open"
  const { state } = clock.transport
  const begins = state === "stopped" || state === "ended" || state === "waiting"
  const beat = begins ? 0 : clock.beat()
  if (open) {
    outlook?.want(beat)
    next?.want(0)
  }
  if (clock.playing && open && controls.showBeat()) timeline.showPosition()
  const present = motion.present(now)
  robots = present.robots
  if (outlook && pending && outlook.version) {
    anchor.set(outlook, pending.poses, pending.beat)
    pending = null
  }
  const newest = motion.newest
  const then = newest && clock.beatAt(newest.at)
  if (outlook && then !== undefined) anchor.look(outlook, newest.poses, then, now, (name) => clock.isSilent(name))
  lights.show(begins ? null : outlook, beat, (index) => stage.color(index), stage.colors.ink)
  const until = outlook?.horizon(beat) ?? 0
  const key = [outlook?.score.generation, outlook?.version, anchor.version, cleared, until].join()
  if (key !== known) {
    known = key
    stale = true
    if (outlook) {
      const points = [...outlook.points(until)]
      const { world } = outlook.score
      room = points.length || world ? bounds([points, world ? outline(world) : []]) : []
      if (!seen && points.length) stage.camera.view = null // the first view is there at once
      seen ||= points.length > 0
    }
  }
  const bumping = bumps.show(present.at, now)
  const news = bumps.news(now)
  if (news) announce(news)
  if (outlook?.version) picture ??= fetchPicture()
  if (stale || present.moving || bumping.length) {
    const ease = stillness.matches ? Infinity : Math.min(now - drawn, 0.1)
    stale = stage.draw(scene(present, beat, until, bumping), ease)
    stale ||= present.moving || bumping.length > 0
  }
  timeline.draw(outlook, stillness.matches)
  drawn = now
  requestAnimationFrame(frame)
}

/** All that the stage shows in this frame. */
function scene({ at, placed, moving }, beat, until, bumping) {
  const { muted, soloed } = clock.transport
  return {
    at,
    placed,
    moving,
    beat,
    until,
    bumps: bumping,
    room: [...room, ...motion.room],
    trails: motion.trails,
    trail: panels.trail,
    ahead: panels.ahead,
    world: outlook?.score.world,
    starts: starts.rings,
    still: stillness.matches,
    signs: [known, panels.trail, panels.ahead, !clock.playing && beat, muted, "|", soloed],
    cast: cast().map((robot) => ({
      ...robot,
      pose: robots[robot.name],
      moved: anchor.of(robot.name),
      silent: clock.isSilent(robot.name),
      way: clock.isSilent(robot.name) ? null : robot.way,
    })),
  }
}

function resize() {
  const hall = find("hall").getBoundingClientRect()
  const card = find("starts").getBoundingClientRect() // the robots must stay in sight of it
  const beside = card.width < hall.width / 2
  const bottom = Math.max(find("tools").offsetHeight + 20, beside ? 0 : card.height)
  stage.resize({ top: 8, bottom, left: beside ? card.width : 0 })
  timeline.resize()
  stale = true
}

function readTheme() {
  stage.readTheme()
  timeline.colors = stage.colors
  lights.forget()
  showCast()
  touch()
}

hold(find("stage"), stage.camera, (point) => starts.grab(point, stage.camera), () => {
  panels.showFit()
  touch()
})
const sizes = new ResizeObserver(resize)
for (const id of ["stage", "tracks"]) sizes.observe(find(id))
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", readTheme)

/** For tests: what the page knows and shows. */
window.improv = Object.freeze({
  get robots() {
    return structuredClone(robots)
  },
  get transport() {
    return structuredClone(clock.transport)
  },
  get beat() {
    return clock.beat()
  },
  get frames() {
    return frames
  },
  get connected() {
    return connection === "open"
  },
  /** Of each robot, until which beat its way is known. */
  get known() {
    return Object.fromEntries([...(outlook?.robots ?? [])].map(([name, way]) => [name, way.at(-1)?.end ?? 0]))
  },
  /** How the ways of robots are moved, which have not begun at their starts. */
  get moved() {
    return Object.fromEntries(cast().flatMap(({ name }) => (anchor.of(name) ? [[name, anchor.of(name)]] : [])))
  },
  get view() {
    return structuredClone(stage.camera.view)
  },
  toScreen: (x, y) => stage.camera.toScreen({ x, y }),
})

readTheme()
resize()
requestAnimationFrame(frame)
