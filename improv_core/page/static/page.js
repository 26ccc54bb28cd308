// @ts-check
// The page: puts its parts together, and tells them what the server says.

import { Bumps } from "./floor/bumps.js"
import { RobotList } from "./score/robot-list.js"
import { Clock } from "./score/clock.js"
import { Controls } from "./controls/controls.js"
import { Deadman } from "./controls/deadman.js"
import { Editor } from "./editor/editor.js"
import { find, findA } from "./base/elements.js"
import { Figures } from "./bodies/figures.js"
import { Formation } from "./floor/formation.js"
import { listenForGestures } from "./floor/gestures.js"
import { connect, isWebsite } from "./net/backend.js"
import { insets as covered } from "./base/covered.js"
import { EmptyState } from "./controls/empty-state.js"
import { Measured } from "./floor/measured.js"
import { Meetings } from "./floor/meetings.js"
import { Misplaced } from "./floor/out-of-place.js"
import { Motion } from "./floor/motion.js"
import { Notices } from "./base/notices.js"
import { Panels } from "./controls/panels.js"
import { listen as listenForPointing } from "./floor/pointing.js"
import { probe } from "./controls/test-probe.js"
import { Program } from "./score/program.js"
import { Scenes } from "./score/scenes.js"
import { PlayingWords, Score } from "./score/score.js"
import { Senses } from "./controls/senses.js"
import { ServerTime } from "./net/server-time.js"
import { Sound } from "./sound/sound.js"
import { Floor } from "./floor/floor.js"
import { StartPoses } from "./floor/start-poses.js"
import { Timeline } from "./timeline/timeline.js"
import { Trails } from "./floor/trails.js"
import { View } from "./floor/view.js"
import { StatusWall } from "./controls/status-wall.js"
import { offerHelp } from "./editor/writing.js"

/** @import { Message, Messages } from "./net/messages.js" */
/** @import { Change } from "./editor/pending-changes.js" */

const clock = new Clock()
const serverTime = new ServerTime(clock)
const motion = new Motion()
const trails = new Trails()
const measured = new Measured()
const bumps = new Bumps(find("bumps"))
const robotList = new RobotList()
const figures = new Figures()
const notices = new Notices()
const floor = new Floor(findA("stage", HTMLCanvasElement))
const emptyState = new EmptyState()
const send = connect(take, change, (waits, who) => notices.waitForStop(waits, who), (line) => notices.load(line))
const editor = new Editor(send, {
  finish: () => startPoses.tell(),
  place: (starts) => startPoses.place(starts),
  say: (problem) => {
    for (const id of ["start-poses-problem", "sound-problem"]) Object.assign(find(id), { textContent: problem, hidden: !problem })
  },
})
offerHelp(editor.saving, () => (clock.transport.state === "paused" && editor.isPlayed && !clock.atStart ? clock.beat() : 0))
const score = new Score(find("score-text"))
const playingWords = new PlayingWords(
  { show: (message) => shownText().show(message), light: (places, poses) => (editor.open ? editor.light(places) : score.light(places, poses)) },
  clock,
)
const program = new Program(clock, send)
const controls = new Controls(clock, (request) => {
  if (request.type === "stop" || request.type === "pause") editor.saving.halt()
  send(request)
})
const meetings = new Meetings(find("meetings"), (beat) => controls.seek(beat), () => clock.beat())
const misplaced = new Misplaced(send, (text) => notices.announce(text))
const deadman = new Deadman(send)
const timeline = new Timeline(clock, measured, (name) => wall.lost(name), (beat) => controls.seek(beat), (muted, soloed) => send({ type: "silence", muted, soloed }))
const wall = new StatusWall(clock, measured, resize)
const scenes = new Scenes(clock, (beat) => controls.seek(beat))
const sound = new Sound(clock, { say: (line) => notices.announce(line), resize, askTime: (on) => serverTime.keepAsking(on) })
const senses = new Senses(clock, send, () => view.touch())
const formation = new Formation()
const startPoses = new StartPoses(() => view.touch())
const panels = new Panels({
  touch: () => view.touch(),
  resize,
  announce: (text) => notices.announce(text),
  getPicture: () => program.getPicture(),
  clearTrails: () => view.clearTrails(),
  cue: () => senses.cue(),
  getStem: () => emptyState.stem,
  controls,
  camera: floor.camera,
  canvas: findA("stage", HTMLCanvasElement),
})
const view = new View({ clock, figures, motion, trails, measured, bumps, robotList, program, floor, panels, startPoses, senses, meetings, misplaced, wall })

/** @param {Message} message */
function take(message) {
  if (message.type === "poses") takePoses(message)
  else if (message.type === "time") clock.takeTime(message)
  else if (message.type === "trails") trails.take(message)
  else if (message.type === "measured") takeMeasured(message)
  else if (message.type === "program") takeProgram(message)
  else if (message.type === "robots") takeRobots(message)
  else if (message.type === "transport") takeTransport(message)
  else if (message.type === "score") takeScore(message)
  else if (message.type === "window") program.takeWindow(message)
  else if (message.type === "bumps") bumps.take(message)
  else if (message.type === "meetings") takeMeetings(message)
  else if (message.type === "misplaced") takeMisplaced(message)
  else if (message.type === "armed") takeArmed(message)
  else if (message.type === "sensed") takeSensed(message)
  else if (message.type === "joints") figures.takeReal(message)
  else if (message.type === "decided") timeline.mark(message)
  else if (message.type === "vitals") wall.takeVitals(message)
  else if (message.type === "link") wall.takeLink(message, performance.now())
  else if (message.type === "fault") takeFault(message)
  else if (message.type === "why_still") sayWhyStill(message)
  else if (message.type === "source") takeSource(message)
  else if (message.type === "stopped") takeEnd(message)
  else editor.takeAnswer(message)
  view.touch()
}

/** @param {Messages["fault"]} message */
function takeFault(message) {
  wall.takeFault(message)
  if (message.line) notices.announce(message.line)
}

/** @param {Messages["misplaced"]} message */
function takeMisplaced(message) {
  misplaced.take(message)
  resize()
}

/** @param {Messages["why_still"]} message */
function sayWhyStill({ line }) {
  notices.say(line)
  resize()
}

/** @param {Messages["armed"]} message */
function takeArmed(message) {
  controls.takeArmed(message)
  sound.takeArmed(message)
  if (message.armed) notices.announce(controls.spoken())
  showTransport()
}

/** @param {Messages["score"]} message */
function takeScore(message) {
  deadman.require(message.deadman)
  if (message.takes_start_poses) writeWith((change) => send({ type: "change", number: 0, change }))
  if (program.takeScore(message)) showProgram()
}

/** @param {(change: Change) => void} ask asks for the lines that make a change */
function writeWith(ask) {
  startPoses.write = (start_poses) => ask({ type: "place", start_poses })
  formation.write = (chosen) => ask({ type: "arrange", ...chosen })
  sound.write = {
    firstBeat: (value) => ask({ type: "tune", key: "first_beat", value }),
    tempo: (value) => ask({ type: "tune", key: "beat", value }),
  }
}

/** @param {Messages["measured"]} message */
function takeMeasured(message) {
  measured.take(message)
  timeline.showMeasured()
}

/** @param {Messages["program"]} message */
function takeProgram(message) {
  emptyState.take(message)
  showTransport()
}

/** @param {Messages["meetings"]} message */
function takeMeetings(message) {
  meetings.take(message)
  showMeetings()
}

function showMeetings() {
  timeline.showMeetings(meetings.show(program.current?.score.generation, clock.bar))
}

/** @param {Messages["source"]} message */
function takeSource(message) {
  if (!editor.takeSource(message)) return
  writeWith((change) => editor.pendingChanges.add(change))
  controls.writes = () => {
    startPoses.tell()
    const writes = !editor.isPlayed
    if (writes) editor.saving.write()
    return writes
  }
  panels.openScore()
  showTransport()
}

/** The place of the program. */
function shownText() {
  return editor.open ? editor : score
}

/** @param {Messages["sensed"]} message */
function takeSensed(message) {
  senses.take(message)
  if (message.generation === program.current?.score.generation) program.current.renew(message.beat)
}

/** @param {Messages["poses"]} message */
function takePoses({ at, placed, poses, joints }) {
  const named = robotList.named(poses)
  if (named && motion.take({ at, placed, poses: named, joints }, seconds())) bumps.clear()
}

/** @param {Messages["robots"]} message */
function takeRobots(message) {
  robotList.take(message)
  trails.keep(new Set(robotList.names))
  const names = robotList.names.join(", ")
  find("stage").setAttribute("aria-label", `The stage, seen from above${names && `, with ${names}`}`)
}

/** @param {Messages["transport"]} message */
function takeTransport(message) {
  const { generation, restarted, state } = clock.transport
  const jumped = clock.take(message)
  const begins = message.generation !== generation
  if (begins) bumps.clear()
  if (message.restarted !== restarted) {
    trails.restart()
    measured.restart()
    figures.restart()
    timeline.showMeasured()
    senses.restart()
    wall.restart()
    timeline.forgetMarks()
  }
  if (jumped && !begins) trails.seek(message.beat, message.poses)
  if (program.takeTransport(message, jumped || message.state !== state)) showProgram()
  sound.take()
  if (message.state === "stopped" || message.state === "paused") editor.saving.halt()
  if (begins || message.state !== state) notices.announce(controls.spoken())
  if (message.state === "ended" || message.state === "stopped") panels.finish()
  showTransport()
}

/** @param {Messages["stopped"]} message */
function takeEnd(message) {
  const { transport } = clock
  if (!message.message && ["playing", "paused", "waiting"].includes(transport.state)) {
    takeTransport({ type: "transport", ...transport, state: "stopped", beat: clock.beat() }) // perhaps nobody sends that any more
  }
  notices.end(message)
}

/** @param {"open" | "lost" | "refused"} now */
function change(now) {
  if (now === "open") {
    motion.clear() // nobody knows where the robots went in the meantime
    bumps.clear()
    program.reconnect()
    serverTime.connect()
  }
  notices.change(now)
  editor.connect(now === "open")
  sound.connect(now === "open")
  view.touch()
  showTransport()
}

function showProgram() {
  if (!program.current) return
  clock.bar = program.current.score.bar
  playingWords.showText(program.current.score)
  scenes.show(program.current.score)
  sound.show(program.current.score)
  const [kind, meaning] = dynamics(Object.values(program.current.score.robots))
  showMeetings()
  const [none, gap] = isWebsite ? [", nobody bumps", " On this website, robots go through each other and through walls."] : ["", ""]
  Object.assign(find("dynamics"), { textContent: kind + none, title: meaning + gap })
  showCast()
}

function showCast() {
  if (!program.current) return
  const { score } = program.current
  const playing = robotList
    .list(program.current, (index) => floor.color(index))
    .filter(({ name }) => Object.hasOwn(score.robots, name))
  timeline.show(score, playing)
  figures.show(score, playing)
  startPoses.show(score, playing)
  formation.show(score)
  senses.show(score, playing)
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
  controls.show(notices.connection)
  const { robots = {} } = program.current?.score ?? {}
  const played = clock.transport.generation > 0
  emptyState.show(notices.connection === "open", played, !program.current || Object.keys(robots).length > 0)
  find("next").hidden = !program.next || notices.connection !== "open" || !clock.playing
  timeline.showSilence()
  showPosition()
}

function showPosition() {
  timeline.showPosition()
  scenes.showPosition()
}

/** Shows how long ago robots were seen that are lost now. */
function showLost() {
  view.touch()
  timeline.showMeasured()
}

function frame() {
  const now = seconds()
  const beat = clock.atStart ? 0 : clock.beat()
  const open = notices.connection === "open"
  deadman.look(performance.now())
  if (wall.show(performance.now())) showLost()
  if (open) program.want(beat)
  if (clock.playing && open && controls.showBeat()) showPosition()
  controls.showCount()
  program.place(motion.newest, now)
  playingWords.show(clock.atStart ? null : program.current, beat, (index) => floor.color(index), floor.colors.ink)
  view.draw(now, beat)
  const news = bumps.news(now)
  if (news) notices.announce(news)
  timeline.draw(program.current, view.still)
  sound.draw(timeline.shown)
  requestAnimationFrame(frame)
}

function seconds() {
  return performance.now() / 1000
}

function resize() {
  const { insets, strip } = covered(panels.presenting)
  floor.resize(insets, strip)
  timeline.resize()
  view.touch()
}

function readTheme() {
  floor.readTheme()
  timeline.colors = floor.colors
  playingWords.forget()
  showCast()
  view.touch()
}

listenForGestures(findA("stage", HTMLCanvasElement), floor.camera, (point) => startPoses.grab(point, floor.camera), () => {
  panels.showFit()
  view.touch()
})
listenForPointing(
  findA("stage", HTMLCanvasElement),
  (point) => {
    const meeting = meetings.at(point, floor.camera)
    if (meeting !== meetings.pointed) view.touch()
    meetings.pointed = meeting
    Object.assign(find("stage"), { title: meeting?.words ?? "" }).style.cursor = meeting ? "pointer" : ""
    return startPoses.ringAt(point, floor.camera) ?? floor.robotAt(point)
  },
  (name) => {
    if (name === floor.pointed) return
    floor.pointed = name
    view.touch()
  },
)
meetings.listen(findA("stage", HTMLCanvasElement), floor.camera)
const sizes = new ResizeObserver(resize)
for (const id of ["stage", "tracks", "senses"]) sizes.observe(find(id))
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", readTheme)

Object.assign(window, { improv: probe({ robotList, clock, measured, motion, notices, program, sound, floor, trails, view }, seconds) })

readTheme()
resize()
requestAnimationFrame(frame)
