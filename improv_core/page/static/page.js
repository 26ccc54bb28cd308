// @ts-check
// The page: puts its parts together, and hands them what the server says.

import { forgetColors } from "./base/colors.js"
import { insets as covered } from "./base/covered.js"
import { find, findA } from "./base/elements.js"
import { due, redraw, refit, showFrames } from "./base/frames.js"
import { announce, notices } from "./base/notices.js"
import { watchPresses, whenReleased } from "./base/pressing.js"
import { Figures } from "./bodies/figures.js"
import { editing, showBeat, showCount, showTransport as showControls, spoken } from "./controls/controls.js"
import { Gesturing } from "./controls/gesturing.js"
import { Deadman } from "./controls/deadman.js"
import { showHint, showProblems } from "./controls/empty-state.js"
import { offerFiles, recordDance } from "./controls/export.js"
import { Panels } from "./controls/panels.js"
import { showScene, showScenes } from "./controls/scenes.js"
import { seek } from "./controls/seek.js"
import { Senses } from "./controls/senses.js"
import { wall } from "./controls/status-wall.js"
import { Editor } from "./editor/editor.js"
import { offerWords } from "./editor/word-row.js"
import { Bumps } from "./floor/bumps.js"
import { Floor } from "./floor/floor.js"
import { Formation } from "./floor/formation.js"
import { listenForGestures } from "./floor/gestures.js"
import { measured } from "./floor/measured.js"
import { Meetings } from "./floor/meetings.js"
import { Motion } from "./floor/motion.js"
import { Misplaced } from "./floor/out-of-place.js"
import { listen as listenForPointing } from "./floor/pointing.js"
import { startPoses } from "./floor/start-poses.js"
import { Trails } from "./floor/trails.js"
import { View } from "./floor/view.js"
import { connect, isWebsite } from "./net/backend.js"
import { send, sendBy } from "./net/send.js"
import { askTime } from "./net/server-time.js"
import { changes } from "./score/changes.js"
import { clock } from "./score/clock.js"
import { program } from "./score/program.js"
import { robotList } from "./score/robot-list.js"
import { PlayingWords, Score } from "./score/score.js"
import { Sound } from "./sound/sound.js"
import { Timeline } from "./timeline/timeline.js"
import { isClass, joinClass } from "./website/class.js"
import { offerExamples } from "./website/examples.js"
import { offerGuide } from "./website/guide.js"
import { offerSharing } from "./website/share.js"
import { stillOf } from "./website/still.js"

/** @import { Point } from "./floor/camera.js" */
/** @import { Change } from "./score/changes.js" */

// First of all, so that Stop works even if a part of the page fails.
const put = connect(take, connection)
sendBy((request) => {
  put(request)
  if (request.type === "stop" || request.type === "pause") editor.saving.halt()
})

const stage = findA("stage", HTMLCanvasElement)
const motion = new Motion()
const trails = new Trails()
const bumps = new Bumps(find("bumps"))
const figures = new Figures()
const floor = new Floor(stage)
const deadman = new Deadman()
const misplaced = new Misplaced()
const sound = new Sound()
const senses = new Senses()
const formation = new Formation()
const timeline = new Timeline()
const meetings = new Meetings(find("meetings"), seek, () => (clock.atStart ? 0 : clock.beat()))
const editor = new Editor()
const score = new Score()
const playingWords = new PlayingWords((lights) => (editor.open ? editor : score).light(lights))
const panels = new Panels(floor.camera)
const { preview, handle } = editor
const gesturing = new Gesturing(editor, floor, (transport) => sound.clickFor(transport), () => panels.showFit())
const parts = { preview, handle, gesturing, figures, motion, trails, bumps, floor, panels, startPoses, senses, meetings, misplaced, wall }
/** @typedef {typeof parts} Parts */
const view = new View(parts)

/** For each type of message, the part of the page that takes it. @type {{ [T in Message["type"]]: (message: Messages[T]) => void }} */
const HANDLERS = {
  time: (message) => clock.takeTime(message),
  robots: (message) => {
    robotList.take(message)
    trails.keep(new Set(robotList.names))
    const names = robotList.names.join(", ")
    stage.setAttribute("aria-label", `The stage, seen from above${names && `, with ${names}`}`)
  },
  poses: ({ poses, ...message }) => {
    const named = robotList.named(poses)
    if (named && motion.take({ ...message, poses: named }, seconds())) bumps.clear()
  },
  trails: (message) => trails.take(message),
  measured: (message) => {
    measured.take(message)
    timeline.showMeasured()
  },
  joints: (message) => figures.takeReal(message),
  bumps: (message) => bumps.take(message),
  program: (message) => {
    program.take(message)
    showProblems(message)
    showTransport()
  },
  score: (message) => {
    deadman.require(message.deadman)
    if (message.takes_start_poses) writeWith((change) => send({ type: "change", number: 0, change }))
    if (program.takeScore(message)) showProgram()
  },
  window: (message) => program.takeWindow(message),
  transport: takeTransport,
  armed: (message) => {
    clock.takeArmed(message)
    sound.run()
    if (message.armed) announce(spoken())
    showTransport()
  },
  misplaced: (message) => misplaced.take(message),
  meetings: (message) => {
    meetings.take(message)
    showMeetings()
  },
  sensed: (message) => senses.take(message),
  decided: (message) => timeline.mark(message),
  vitals: (message) => wall.takeVitals(message),
  link: (message) => wall.takeLink(message, performance.now()),
  fault: (message) => wall.takeFault(message),
  why_still: (message) => notices.takeWhyStill(message, (beat) => send({ type: "resume", beat })),
  stopped: (message) => {
    const { transport } = clock
    if (!message.message && ["playing", "paused", "waiting"].includes(transport.state)) {
      takeTransport({ ...transport, state: "stopped", beat: clock.beat() }) // perhaps nobody sends that any more
    }
    notices.takeStopped(message)
  },
  source: takeSource,
  analyze: (message) => editor.takeAnalysis(message),
  check: (message) => editor.takeProblems(message),
  complete: (message) => editor.offer.take(message),
  handle: (message) => {
    if (handle.take(message)) gesturing.takePens(message.pens)
  },
  preview: (message) => editor.takePreview(message),
  draft: ({ text, paths }) => {
    preview.edit(text)
    preview.take(paths, text)
  },
  explain: (message) => editor.takeExplanation(message),
  write: (message) => editor.saving.takeWritten(message),
  change: (message) => editor.pendingChanges.take(message),
}

/** Messages that change nothing on the stage, but may move controls. */
const OFF_STAGE = new Set(["analyze", "check", "complete", "explain", "handle", "preview", "write", "change", "source", "program"])

/** @template {Message["type"]} T @param {Messages[T] & { type: T }} message */
function take(message) {
  if (OFF_STAGE.has(message.type)) return whenReleased(() => HANDLERS[message.type](message))
  HANDLERS[message.type](message)
  redraw()
}

/** @param {Messages["transport"]} message */
function takeTransport(message) {
  const { generation, restarted, state } = clock.transport
  const { text } = program
  const jumped = clock.take(message)
  const begins = message.generation !== generation
  if (begins) bumps.clear()
  if (message.restarted !== restarted) {
    for (const part of [trails, measured, figures, senses, wall, timeline]) part.restart()
    timeline.showMeasured()
  }
  if (jumped && !begins) trails.seek(message.beat, message.poses)
  if (program.takeTransport(message, jumped || message.state !== state)) showProgram()
  if (message.restarted !== restarted && program.text !== text) floor.camera.forget()
  sound.run()
  if (message.state === "stopped" || message.state === "paused") editor.saving.halt()
  if (begins || message.state !== state) announce(spoken())
  recordDance(stage)
  showTransport()
}

/** @param {Messages["source"]} message */
function takeSource(message) {
  if (!editor.takeSource(message)) return
  writeWith((change) => editor.pendingChanges.add(change))
  editing.writes = () => {
    startPoses.tell()
    const writes = !editor.isPlayed
    if (writes) editor.saving.write()
    return writes
  }
  panels.openScore()
  showTransport()
}

/** @param {(change: Change) => void} write */
function writeWith(write) {
  changes.write = write
  startPoses.showLines()
}

/** @param {"open" | "lost" | "refused"} now */
function connection(now) {
  if (now === "open") {
    motion.clear() // nobody knows where the robots went in the meantime
    bumps.clear()
    program.reconnect()
    clock.connect()
    askTime()
  }
  notices.change(now)
  editor.reconnect()
  sound.reconnect()
  redraw()
  showTransport()
}

function showProgram() {
  if (!program.current) return
  const { score: message } = program.current
  if (!editor.open) score.show(message.text)
  playingWords.forget()
  showScenes(message)
  sound.show()
  showMeetings()
  const [kind, meaning] = dynamics(Object.values(message.robots))
  const [none, gap] = isWebsite ? [", nobody bumps", " On this website, robots go through each other and through walls."] : ["", ""]
  Object.assign(find("dynamics"), { textContent: kind + none, title: meaning + gap })
  showCast()
}

/** Shows the robots of the score, in their colors. */
function showCast() {
  if (program.current) for (const part of [timeline, figures, startPoses, formation, senses]) part.show(program.current.score)
}

function showMeetings() {
  timeline.showMeetings(meetings.show(program.current?.score.generation, program.bar))
}

/**
 * The simulator's kind of motion, and its meaning, so that nobody takes ideal motion for the real world.
 * @param {{ dynamics: string }[]} robots
 */
function dynamics(robots) {
  const kinds = new Set(robots.map((robot) => robot.dynamics))
  const some = kinds.size > 1 ? "some " : ""
  if (kinds.has("motors")) return [`${some}with motors`, "Simulated robots speed up and slow down like real ones."]
  if (kinds.has("limits")) return [`${some}within limits`, "Simulated robots are no faster than the limits of their profiles allow."]
  return ["ideal motion", "Simulated robots change speed at once and are exactly where the program puts them. Real ones are not."]
}

function showTransport() {
  showControls()
  showHint()
  find("next").hidden = !program.next || !notices.isOpen || !clock.playing
  timeline.showSilence()
  gesturing.showButtons()
  showPosition()
}

function showPosition() {
  meetings.showAhead()
  timeline.showPosition()
  showScene()
}

/** Returns whether the next frame will show something else, whatever happens. */
function frame() {
  const now = seconds()
  const beat = clock.atStart ? 0 : clock.beat()
  if (due.fit) fit()
  if (deadman.isRequired) deadman.look(performance.now())
  if (wall.show(performance.now())) timeline.showMeasured()
  if (notices.isOpen) program.want(beat)
  if (clock.playing && notices.isOpen && showBeat()) showPosition()
  showCount()
  program.place(motion.newest, now)
  playingWords.show()
  const performs = gesturing.advance(now)
  view.draw(now, beat)
  preview.showButton()
  const news = bumps.news(now, (robot) => program.label(robot))
  if (news) announce(news)
  timeline.draw(view.still)
  sound.draw(timeline.shown)
  return performs || clock.playing || clock.count !== null || deadman.isRequired
}

/** The page's time. */
const seconds = () => performance.now() / 1000

function fit() {
  due.fit = false
  const { insets, strip } = covered(panels.presenting)
  floor.resize(insets, strip)
  timeline.resize()
}

offerFiles(stage)
const writing = findA("text", HTMLTextAreaElement)
offerWords(writing)
// On a website, what somebody chooses plays at once. Elsewhere, real robots may play, and a file is written: that takes another press.
const choose = (/** @type {string} */ text, toml = "") => {
  editor.saving.replace(text, isWebsite ? toml : undefined)
  if (isWebsite) editor.saving.write()
}
offerExamples((text, toml) => {
  choose(text, toml)
  writing.setSelectionRange(0, 0)
  find("paper").scrollTop = 0 // its first lines explain it
})
offerGuide(choose)
offerSharing(
  editor.saving,
  () => (clock.transport.state === "paused" && editor.isPlayed && !clock.atStart ? clock.beat() : 0),
  (text) => stillOf(preview.linesOf(text)),
)
if (isClass) joinClass(editor.saving)

/** @param {Point} point @param {() => boolean} freely whether Alt is pressed */
const grab = (point, freely) =>
  gesturing.grab(point) ?? handle.grab(point, floor.camera, freely) ?? startPoses.grab(point, floor.camera)
listenForGestures(stage, floor.camera, grab, () => panels.showFit())
listenForPointing(
  stage,
  (point) => {
    meetings.point(stage, point, floor.camera)
    return startPoses.ringAt(point, floor.camera) ?? floor.robotAt(point)
  },
  (name) => floor.point(name),
)
meetings.listen(stage, floor.camera)

const sizes = new ResizeObserver(refit)
for (const id of ["stage", "tracks", "senses", "gesture", "hint"]) sizes.observe(find(id))
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  forgetColors()
  playingWords.forget()
  showCast()
  redraw()
})

/** For tests: the page's state and display. */
const improv = {
  get robots() { return view.robots },
  get transport() { return clock.transport },
  get beat() { return clock.beat() },
  get connected() { return notices.isOpen },
  get known() { return Object.fromEntries([...(program.current?.robots ?? [])].map(([name, path]) => [name, path.at(-1)?.end ?? 0])) }, // up to a beat
  get drawn() { return floor.poses }, // real robots where they were seen
  get moved() { return Object.fromEntries(program.anchor.moved) },
  get view() { return floor.camera.view },
  get rests() { return !due.draw && !due.fit }, // the latest frame shows all that there is
  get handle() { return handle.shown },
  get previewed() { return preview.painted },
  get song() { return sound.audio?.position(seconds()) ?? null },
  toScreen: (/** @type {number} */ x, /** @type {number} */ y) => floor.camera.toScreen({ x, y }),
}
Object.assign(window, { improv })
showFrames(frame)
watchPresses()
