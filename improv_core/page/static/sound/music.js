// @ts-check
// The times of sounds: a song and a click, locked to the beat. Pure: nothing here knows a browser. All times are in
// seconds on the audio context's clock, as heard: a sound that the context plays at a time is heard at that time.

/** @typedef {{ time: number, beat: number, pace: number, until: number }} BeatLine at `time` it is this beat, and beats pass at `pace` a second, up to beat `until` */
/** @typedef {{ time: number, position: number, rate: number }} SongLine at `time` the song should be at `position`, in seconds from its beginning, and positions pass at `rate` */
/** @typedef {{ page: number, audio: number }} Hearing at time `page` of the page, in seconds, the sound of time `audio` of the context is audible */
/**
 * A sound that plays: the song itself from a position on, at a speed; or grains of it up to a time, made for a line.
 * @typedef {{ kind: "song", time: number, position: number, speed: number }} PlaysSong
 * @typedef {{ kind: "grains", until: number, line: SongLine, next: number | null }} PlaysGrains `next`: the position that follows the last grain
 * @typedef {PlaysSong | PlaysGrains | null} Plays
 */
/**
 * @typedef {{ act: "end", at: number } | { act: "start", at: number, position: number, speed: number }
 *   | { act: "bend", at: number, speed: number } | { act: "grain", at: number, position: number, length: number }} Act
 */
/** @typedef {{ next: number, line: BeatLine } | null} Clicks those before a beat are scheduled, for a line */
/** @typedef {{ act: "click", at: number, high: boolean } | { act: "unclick", at: number }} ClickAct */

export const SLOWEST = 0.5 // of the song's own speed: beyond these two, there is no song
export const FASTEST = 2
export const BEND = 0.005 // of the speed, by which the song itself is bent: nobody hears that
const BEND_AFTER = 0.0005 // seconds that the song may be off before it is bent
const JUMP_AFTER = 0.008 // seconds beyond which it jumps, with a short fade
const CORRECTION_TIME = 1 // seconds in which it would be right again if bent without limit
const MIN_BEND = 0.0001 // of the speed: smaller changes are not worth it
const SMEAR = 0.01 // seconds by which a grain may be off at its ends
const MIN_GRAIN = 0.03 // seconds of a grain
const MAX_GRAIN = 0.25
const BEGINNING = 0.5 // seconds after which a browser that doesn't report what is audible at least knows its latency
const MAX_HEARINGS = 15 // hearings
const HEARING_LIFE = 5 // seconds after which one no longer counts: two clocks drift
const MOVED_BY = 0.03 // seconds that hearings may differ before the earlier ones are forgotten
const MOVED_COUNT = 3 // hearings that have to differ
const CLICK_TOLERANCE = 0.003 // seconds by which clicks may be off before they are scheduled again
const MAX_LATENESS = 0.05 // seconds by which a click may be late: beyond that, there is none

/**
 * The sound that is heard now, as the browser reports it: a time of the context, and the time at which it is audible. A
 * browser that doesn't report that may know its latency, but not while it has only begun: then null.
 * @param {{ contextTime?: number, performanceTime?: number }} stamp of the output, the page's in milliseconds
 * @param {{ currentTime: number, outputLatency?: number, baseLatency?: number }} context
 * @param {number} now of the page, in seconds
 * @returns {Hearing | null}
 */
export function hearing({ contextTime = 0, performanceTime = 0 }, { currentTime, outputLatency = 0, baseLatency = 0 }, now) {
  if (contextTime > 0 && performanceTime > 0) return { page: performanceTime / 1000, audio: contextTime }
  return currentTime < BEGINNING ? null : { page: now, audio: currentTime - (outputLatency || baseLatency) }
}

/**
 * The hearings that count after another one. If the sound has moved, such as after a sleep or to another loudspeaker,
 * earlier ones don't count; a single one that is far off shows only that the machine was busy.
 * @param {Hearing[]} hearings
 * @param {Hearing} hearing
 */
export function heard(hearings, hearing) {
  const all = [...hearings.filter(({ page }) => hearing.page - page < HEARING_LIFE), hearing].slice(-MAX_HEARINGS)
  const latest = all.slice(-MOVED_COUNT)
  const moved = latest.every((each) => Math.abs(shift([each]) - shift(all)) > MOVED_BY)
  return moved ? latest : all
}

/** Seconds by which the audio context's clock is ahead of the page's, for audible sound. @param {Hearing[]} hearings */
export function shift(hearings) {
  const shifts = hearings.map(({ page, audio }) => audio - page).sort((one, two) => one - two)
  return shifts[Math.floor(shifts.length / 2)] ?? 0
}

/**
 * The line of beats that a transport message describes; null if nothing plays.
 * @param {{ state: string, beat: number, beats: number | null, tempo: number, wall: number }} transport
 * @param {number} lead by how many seconds the audio context's clock, as heard, is ahead of the server's
 * @returns {BeatLine | null}
 */
export function beatLine({ state, beat, beats, tempo, wall }, lead) {
  return state === "playing" ? { time: wall + lead, beat, pace: tempo / 60, until: beats ?? Infinity } : null
}

/**
 * The line of the beats that are counted before beat 0, and of beat 0 itself, which nobody says early enough; null if
 * none are.
 * @param {{ begins: number, beats: number, period: number } | null} counting
 * @param {number} lead
 * @returns {BeatLine | null}
 */
export function countLine(counting, lead) {
  if (!counting) return null
  const { begins, beats, period } = counting
  return { time: begins - beats * period + lead, beat: -beats, pace: 1 / period, until: 0.5 }
}

/** @param {BeatLine} line @param {number} time */
export function beatAt({ time: begun, beat, pace }, time) {
  return beat + (time - begun) * pace
}

/** @param {BeatLine} line @param {number} beat */
function timeAt({ time: begun, beat: first, pace }, beat) {
  return begun + (beat - first) / pace
}

/**
 * The part of a song that should be heard; null if none should.
 * @param {BeatLine | null} line
 * @param {{ firstBeat: number, tempo: number }} song where beat 0 is in it, and the tempo at which it has its own speed
 * @returns {SongLine | null}
 */
export function songLine(line, { firstBeat, tempo }) {
  if (!line) return null
  const rate = (line.pace * 60) / tempo
  const [slow, fast] = [SLOWEST - 1e-9, FASTEST + 1e-9]
  return rate < slow || rate > fast ? null : { time: line.time, position: firstBeat + (line.beat * 60) / tempo, rate }
}

/** @param {SongLine} line @param {number} time */
export function positionAt({ time: begun, position, rate }, time) {
  return position + (time - begun) * rate
}

/**
 * The steps to get to the right position: nothing, a bend, a jump with a fade, or grains, which keep
 * the pitch at another speed. `now` is the earliest time for which something can be scheduled, and `ahead` the time up
 * to which it should be. `length` is that of the song, and `align` finds the position near `wanted` at which a grain
 * joins best what comes after `from`.
 * @param {Plays} plays
 * @param {SongLine | null} line
 * @param {{ now: number, ahead: number, length: number, align?: (from: number, wanted: number) => number }} how
 * @returns {[Plays, Act[]]}
 */
export function follow(plays, line, { now, ahead, length, align = (_, wanted) => wanted }) {
  const bends = line !== null && Math.abs(line.rate - 1) <= BEND
  /** @type {Act[]} */
  const end = plays ? [{ act: "end", at: now }] : []
  if (!line || positionAt(line, now) >= length || positionAt(line, ahead) < 0) return [null, end]
  if (bends && plays?.kind === "song") {
    const position = plays.position + (now - plays.time) * plays.speed
    const late = positionAt(line, now) - position
    const asked = line.rate + (Math.abs(late) > BEND_AFTER ? within(late / CORRECTION_TIME, BEND) : 0)
    const speed = Math.abs(asked - plays.speed) > MIN_BEND ? asked : plays.speed
    if (Math.abs(late) <= JUMP_AFTER && speed === plays.speed) return [plays, []]
    if (Math.abs(late) <= JUMP_AFTER) return [{ kind: "song", time: now, position, speed }, [{ act: "bend", at: now, speed }]]
  }
  if (bends) {
    const at = Math.max(now, line.time - line.position / line.rate)
    const position = Math.max(positionAt(line, at), 0)
    return [{ kind: "song", time: at, position, speed: line.rate }, [...end, { act: "start", at, position, speed: line.rate }]]
  }
  const goesOn = plays?.kind === "grains" && plays.until >= now && isNear(plays.line, line, plays.until)
  return grains(goesOn ? plays : null, line, { now, ahead, length, align, acts: goesOn ? [] : end })
}

/**
 * Grains of the song up to a time, each at its own speed, so that the pitch stays.
 * @param {PlaysGrains | null} plays
 * @param {SongLine} line
 * @param {{ now: number, ahead: number, length: number, align: (from: number, wanted: number) => number, acts: Act[] }} how
 * @returns {[Plays, Act[]]}
 */
function grains(plays, line, { now, ahead, length, align, acts }) {
  const span = grainLength(line.rate)
  let until = plays?.until ?? Math.max(now, line.time - line.position / line.rate)
  let next = plays?.next ?? null
  while (until < ahead && positionAt(line, until) < length) {
    const wanted = Math.max(positionAt(line, until + span / 2) - span / 2, 0) // right in its middle
    const position = next === null ? wanted : Math.max(align(next, wanted), 0)
    acts.push({ act: "grain", at: until, position, length: span })
    until += span
    next = position + span
  }
  return [{ kind: "grains", until, line, next }, acts]
}

/** The length of a grain in seconds: short enough that nothing in it is heard too early or too late. @param {number} rate */
export function grainLength(rate) {
  return Math.min(Math.max((2 * SMEAR * rate) / Math.abs(1 - rate), MIN_GRAIN), MAX_GRAIN)
}

/** @param {SongLine} one @param {SongLine} two @param {number} time */
function isNear(one, two, time) {
  return Math.abs(positionAt(one, time) - positionAt(two, time)) / two.rate <= JUMP_AFTER && Math.abs(one.rate - two.rate) <= BEND
}

/** @param {number} value @param {number} most */
function within(value, most) {
  return Math.min(Math.max(value, -most), most)
}

/**
 * The clicks to schedule, or to take back because their beats come at other times now.
 * @param {Clicks} clicks
 * @param {BeatLine | null} line
 * @param {{ now: number, ahead: number, bar: number | null }} how
 * @returns {[Clicks, ClickAct[]]}
 */
export function click(clicks, line, { now, ahead, bar }) {
  const off = clicks && (!line || Math.abs(beatAt(line, timeAt(clicks.line, clicks.next)) - clicks.next) > CLICK_TOLERANCE * line.pace)
  /** @type {ClickAct[]} */
  const acts = off ? [{ act: "unclick", at: now }] : []
  if (!line) return [null, acts]
  const present = beatAt(line, now)
  const heard = clicks && off ? beatAt(clicks.line, now) : clicks?.next
  const goesOn = heard !== undefined && (!off || Math.abs(heard - present) < 0.5) // otherwise it is elsewhere in the dance
  const first = goesOn ? Math.max(heard, beatAt(line, now - MAX_LATENESS)) : present
  let next = Math.ceil(Math.max(first, line.beat) - 1e-6)
  for (const end = Math.min(beatAt(line, ahead), line.until - 1e-6); next < end; next++) {
    acts.push({ act: "click", at: Math.max(timeAt(line, next), now), high: bar !== null && next % bar === 0 })
  }
  return [{ next, line }, acts]
}
