// Which sound is heard when: a song and clicks that follow the beat, on an audio clock that the tests turn.

import assert from "node:assert/strict"
import test from "node:test"

import { beatLine, click, countLine, follow, grainLength, heard, hearing, positionAt, shift, songLine } from "../../../improv_core/page/static/sound/music.js"

const SONG = { firstBeat: 0.5, tempo: 120 }
const LENGTH = 300
const transport = (more) => ({ state: "playing", beat: 0, beats: null, tempo: 120, wall: 10, ...more })
const FADE = 0.012

/**
 * Follows lines from 10 s on, and says what is heard every 10 ms: how far it is from the right position, in seconds,
 * and how loud it is. `lineOf` gets the time and returns the line that is known then.
 */
function played(lineOf, { seconds = 10, period = 0.04, ahead = 0.3, length = LENGTH, align } = {}) {
  const voices = []
  const [errors, acts] = [[], []]
  let plays = null
  let next = 10
  for (let time = 10; time < 10 + seconds; time += 0.01) {
    if (time >= next) {
      const [line, now] = [lineOf(time), time + 0.02]
      const [then, made] = follow(plays, line, { now, ahead: now + ahead, length, align })
      plays = then
      for (const act of made) obey(voices, act)
      acts.push(...made)
      next = time + period
    }
    const line = lineOf(time)
    const sounding = voices.filter(({ rises, falls }) => rises <= time && time < falls + FADE)
    const loud = sounding.reduce((sum, voice) => sum + loudness(voice, time), 0)
    for (const voice of sounding) {
      const off = line ? (voice.position + (time - voice.at) * voice.speed - positionAt(line, time)) / line.rate : 0
      if (loudness(voice, time) > 0.5) errors.push({ time, off })
    }
    errors.push({ time, loud })
  }
  return { acts, off: (from, to) => Math.max(...errors.filter(({ time, off }) => off !== undefined && time >= from && time < to).map(({ off }) => Math.abs(off))), loud: (from, to) => errors.filter(({ time, loud }) => loud !== undefined && time >= from && time < to).map(({ loud }) => loud) }
}

function loudness({ rises, falls }, time) {
  return Math.max(Math.min((time - rises) / FADE, 1 - (time - falls) / FADE, 1), 0)
}

function obey(voices, act) {
  if (act.act === "end") {
    for (const voice of voices) voice.falls = voice.rises >= act.at ? -Infinity : Math.min(voice.falls, Math.max(act.at, voice.rises + FADE))
  } else if (act.act === "bend") {
    for (const voice of voices.filter(({ falls }) => falls === Infinity)) {
      Object.assign(voice, { position: voice.position + (act.at - voice.at) * voice.speed, at: act.at, speed: act.speed })
    }
  } else voices.push({ rises: act.at, at: act.at, position: act.position, speed: act.speed ?? 1, falls: act.act === "grain" ? act.at + act.length : Infinity })
}

const lineFrom = (more, lead = 0) => songLine(beatLine(transport(more), lead), SONG)
const names = (acts) => acts.map(({ act }) => act)

/** Numbers from 0 to 1, the same in each run. */
function randomness() {
  let seed = 1
  return () => (seed = (seed * 16807) % 2147483647) / 2147483647
}

test("the song begins with the dance: at beat 0, where its first beat is", () => {
  const { acts, off } = played(() => lineFrom())
  assert.equal(names(acts).join(), "start")
  assert.ok(Math.abs(acts[0].position - (0.5 + (acts[0].at - 10))) < 1e-9)
  assert.ok(off(10.1, 20) < 1e-6)
})

test("a song whose first beat is before its beginning starts later", () => {
  const { acts } = played(() => songLine(beatLine(transport(), 0), { firstBeat: -2, tempo: 120 }))
  assert.deepEqual(acts, [{ act: "start", at: 12, position: 0, speed: 1 }])
})

test("a stop and a pause end it, and it continues where the dance does", () => {
  const paused = (time) => (time < 12 ? lineFrom() : time < 15 ? lineFrom({ state: "paused", beat: 4 }) : lineFrom({ beat: 4, wall: 15 }))
  const { acts, off, loud } = played(paused)
  assert.equal(names(acts).join(), "start,end,start")
  assert.ok(Math.max(...loud(12.1, 15)) === 0)
  assert.ok(off(15.1, 20) < 1e-6)
})

test("a seek jumps with a short fade, and both sounds together are never louder than one", () => {
  const { acts, off, loud } = played((time) => (time < 12.005 ? lineFrom() : lineFrom({ beat: 100, wall: 12 })))
  assert.equal(names(acts).join(), "start,end,start")
  assert.ok(off(12.1, 20) < 1e-6)
  assert.ok(Math.min(...loud(10.1, 20)) > 0.999 && Math.max(...loud(10.1, 20)) < 1.001)
})

test("a save that keeps the beat changes nothing", () => {
  const { acts } = played((time) => (time < 12 ? lineFrom() : lineFrom({ beat: 4, wall: 12 })))
  assert.equal(names(acts).join(), "start")
})

test("an audio clock that is 200 ppm fast is bent after, and nothing jumps", () => {
  const { acts, off } = played((time) => lineFrom({}, (time - 10) * 200e-6), { seconds: 200 })
  assert.ok(acts.every(({ act }) => act === "start" || act === "bend"))
  assert.ok(off(10.1, 210) < 0.001)
  assert.ok(acts.every(({ act, speed }) => act !== "bend" || Math.abs(speed - 1) <= 0.005))
})

test("what is off by less than 8 ms is bent until it is right, by 0.5% at most", () => {
  const { acts, off } = played((time) => (time < 11 ? lineFrom() : lineFrom({}, 0.007)))
  assert.ok(off(11.1, 20) < 0.0075 && off(17, 20) < 0.001)
  assert.ok(acts.every(({ act, speed }) => act === "start" || (act === "bend" && Math.abs(speed - 1) <= 0.005 + 1e-9)))
})

test("hearings that jitter by 3 ms don't make it wobble", () => {
  let hearings = []
  const random = randomness()
  const { acts, off } = played((time) => {
    hearings = heard(hearings, { page: time, audio: time + (random() - 0.5) * 0.006 })
    return lineFrom({}, shift(hearings))
  })
  assert.ok(names(acts).every((act) => act === "start" || act === "bend"))
  assert.ok(off(11, 20) < 0.004)
})

for (const tempo of [60, 90, 110, 118, 132, 150, 180, 240]) {
  test(`at ${tempo} instead of 120 beats a minute, the pitch stays, and nothing is more than 20 ms off`, () => {
    const { acts, off, loud } = played(() => lineFrom({ tempo }), { align: (from, wanted) => wanted })
    assert.ok(acts.every((act) => act.act === "grain"))
    assert.ok(off(10.1, 20) <= 0.0205, String(off(10.1, 20)))
    assert.ok(Math.min(...loud(10.1, 20)) > 0.999 && Math.max(...loud(10.1, 20)) < 1.001)
  })
}

test("a grain is placed where it joins the one before, near where it should be", () => {
  const asked = []
  const align = (from, wanted) => (asked.push([from, wanted]), wanted + 0.004)
  const { acts } = played(() => lineFrom({ tempo: 90 }), { seconds: 2, align })
  assert.equal(asked.length, acts.length - 1)
  assert.ok(asked.every(([from], index) => Math.abs(from - (acts[index].position + acts[index].length)) < 1e-9))
  assert.ok(acts.slice(1).every(({ position }, index) => Math.abs(position - asked[index][1] - 0.004) < 1e-9))
})

test("slower than half and faster than twice its speed, there is no song", () => {
  assert.equal(lineFrom({ tempo: 59 }), null)
  assert.equal(lineFrom({ tempo: 241 }), null)
  assert.ok(lineFrom({ tempo: 60 }) && lineFrom({ tempo: 240 }))
  const { acts } = played((time) => (time < 12 ? lineFrom() : lineFrom({ tempo: 480, beat: 4, wall: 12 })))
  assert.equal(names(acts).join(), "start,end")
})

test("a change of speed ends the grains that were scheduled, and begins others at once", () => {
  const { off } = played((time) => (time < 12 ? lineFrom() : time < 15 ? lineFrom({ tempo: 180, beat: 4, wall: 12 }) : lineFrom({ tempo: 80, beat: 13, wall: 15 })))
  for (const [from, to] of [[10.1, 12], [12.1, 15], [15.1, 20]]) assert.ok(off(from, to) <= 0.0205)
})

test("a tempo that an outside clock bends by 5%, a bit every tenth of a second, never silences it", () => {
  const bent = (time) => {
    const step = Math.floor((time - 10) * 10) / 10
    return lineFrom({ tempo: 120 * (1 + 0.05 * Math.sin(step)), beat: 2 * (step + 0.05 * (1 - Math.cos(step))), wall: 10 + step })
  }
  const { off, loud } = played(bent)
  assert.ok(off(10.1, 20) <= 0.0205, String(off(10.1, 20)))
  assert.ok(Math.min(...loud(10.1, 20)) > 0.98)
})

test("it ends with the song, also if the dance continues", () => {
  const { acts, loud } = played(() => lineFrom(), { length: 3 })
  assert.equal(names(acts).join(), "start,end")
  assert.ok(Math.max(...loud(13, 20)) === 0)
})

test("a tab that slept is right again at its first look, and played on meanwhile", () => {
  const { acts, off } = played(() => lineFrom(), { seconds: 20, period: 7 })
  assert.equal(names(acts).join(), "start")
  assert.ok(off(10.1, 30) < 1e-6)
})

test("grains are scheduled far enough for a hidden page that wakes once a second", () => {
  const { loud } = played(() => lineFrom({ tempo: 90 }), { period: 1, ahead: 2.5 })
  assert.ok(Math.min(...loud(10.1, 20)) > 0.98)
})

test("what is heard later because of the output's latency is scheduled earlier", () => {
  for (const latency of [0, 0.032, 0.2, 0.5]) {
    // The context is at 100 s when the page is at 7 s, and what it plays then is heard `latency` later.
    const hearings = heard([], { page: 7, audio: 100 - latency })
    const ahead = 1_700_000_000 - 7 // the server's clock
    const line = beatLine(transport({ wall: 1_700_000_000 }), shift(hearings) - ahead)
    assert.ok(Math.abs(line.time - (100 - latency)) < 1e-6) // beat 0 was to be played this much earlier, to be heard at 7 s
  }
})

test("a browser that says what is heard is believed, and another one's latency counts", () => {
  const context = { currentTime: 20, outputLatency: 0.18, baseLatency: 0.01 }
  assert.deepEqual(hearing({ contextTime: 19.9, performanceTime: 4000 }, context, 4.01), { page: 4, audio: 19.9 })
  assert.deepEqual(hearing({ contextTime: 0, performanceTime: 0 }, context, 4), { page: 4, audio: 19.82 })
  assert.deepEqual(hearing({}, { ...context, outputLatency: undefined }, 4), { page: 4, audio: 19.99 })
  assert.deepEqual(hearing({}, { currentTime: 20 }, 4), { page: 4, audio: 20 })
  assert.equal(hearing({}, { currentTime: 0.1, outputLatency: 0 }, 4), null) // it has only begun, and doesn't know yet
})

test("hearings are a median of the latest, and begin anew when another loudspeaker is later", () => {
  let hearings = []
  for (const [page, audio] of [[1, 1.1], [1.1, 1.2], [1.2, 1.32], [1.3, 1.4]]) hearings = heard(hearings, { page, audio })
  assert.ok(Math.abs(shift(hearings) - 0.1) < 1e-9)
  for (const page of [1.4, 1.5]) hearings = heard(hearings, { page, audio: page - 0.1 })
  assert.ok(Math.abs(shift(hearings) - 0.1) < 1e-9) // the machine may only have been busy
  hearings = heard(hearings, { page: 1.6, audio: 1.5 })
  assert.ok(Math.abs(shift(hearings) + 0.1) < 1e-9)
  assert.equal(hearings.length, 3)
})

test("hearings from before a long pause don't count, because clocks drift", () => {
  const before = [1, 2, 3].reduce((hearings, page) => heard(hearings, { page, audio: page }), [])
  assert.deepEqual(heard(before, { page: 600, audio: 600.02 }), [{ page: 600, audio: 600.02 }])
})

test("grains are at most 20 ms off at their ends, and long near the song's own speed", () => {
  for (const rate of [0.5, 0.7, 0.95, 1.05, 1.5, 2]) assert.ok((grainLength(rate) / 2) * (Math.abs(1 - rate) / rate) <= 0.02 + 1e-9)
  assert.equal(grainLength(1.01), 0.25)
})

/** The clicks while lines are followed: their times, and which are high. */
function clicked(lineOf, { bar = 4, seconds = 4, period = 0.04, ahead = 0.3 } = {}) {
  let [clicks, made] = [null, []]
  for (let time = 10; time < 10 + seconds; time += period) {
    const [next, acts] = click(clicks, lineOf(time), { now: time + 0.02, ahead: time + 0.02 + ahead, bar })
    clicks = next
    for (const act of acts) made = act.act === "click" ? [...made, act] : made.filter(({ at }) => at < act.at)
  }
  return made.map(({ at, high }) => [Number(at.toFixed(3)), high])
}
const beatsFrom = (more) => beatLine(transport(more), 0)

test("each beat clicks once, and the first of a bar is higher", () => {
  assert.deepEqual(clicked(() => beatsFrom(), { bar: 3, seconds: 2.2 }), [[10.5, false], [11, false], [11.5, true], [12, false], [12.5, false]])
  assert.deepEqual(clicked(() => beatsFrom(), { bar: null, seconds: 1 }), [[10.5, false], [11, false]])
})

test("beat 0 clicks if it is still to come", () => {
  assert.deepEqual(clicked(() => beatsFrom({ wall: 10.05 }), { seconds: 0.5 }), [[10.05, true], [10.55, false]])
})

test("the beats of a count-in click, the first one higher, and go over into those of the dance", () => {
  const counting = countLine({ begins: 12, beats: 3, period: 0.5 }, 0)
  const found = clicked((time) => (time < 12.03 ? counting : beatsFrom({ wall: 12 })), { bar: 3, seconds: 3 })
  assert.deepEqual(found, [[10.5, true], [11, false], [11.5, false], [12, true], [12.5, false], [13, false]])
})

test("clicks that were scheduled for a tempo are taken back when it changes, and none is lost or heard twice", () => {
  const found = clicked((time) => (time < 11 ? beatsFrom() : beatsFrom({ tempo: 60, beat: 2, wall: 11 })), { bar: null })
  assert.deepEqual(found.map(([at]) => at), [10.5, 11, 12, 13, 14])
})

for (const jitter of [0.0005, 0.0014, 0.02]) {
  test(`no click is lost or heard twice while it is known to ${jitter * 1000} ms how late sound is heard`, () => {
    const chance = randomness()
    const found = clicked(() => beatLine(transport(), jitter * (2 * chance() - 1)), { bar: null, seconds: 60 })
    const gaps = found.slice(1).map(([at], place) => at - found[place][0])
    assert.equal(found.length, 120)
    assert.ok(gaps.every((gap) => Math.abs(gap - 0.5) < 0.001 + 2 * jitter), gaps)
  })
}

test("after a pause, only the beats that play click, and none after the last one", () => {
  const found = clicked((time) => (time < 11.2 ? beatsFrom({ beats: 6 }) : time < 12.1 ? null : beatsFrom({ beat: 2.4, beats: 6, wall: 12.1 })), { bar: null, seconds: 5 })
  assert.deepEqual(found.map(([at]) => at), [10.5, 11, 12.4, 12.9, 13.4])
})
