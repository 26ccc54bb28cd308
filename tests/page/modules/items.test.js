// The items of the timeline: a word is one item, however many segments it takes.

import assert from "node:assert/strict"
import test from "node:test"

import { ProgramText } from "../../../improv_core/page/static/score/program-text.js"
import { itemsOf, labels, outline, runs } from "../../../improv_core/page/static/timeline/items.js"

const WORDS = { forward: [1, 0, 0, 0], left: [0, 0, 0, 1], rest: [0, 0, 0, 0] }
const TEXT = "r $ forward left"
const FORWARD = [4, 11]
const LEFT = [12, 16]

/** Segments of equal length that follow each other: each has a word, and its speed. */
function segments(...all) {
  return all.map(([word, speed, beats = 0.125], i) => {
    const start = all.slice(0, i).reduce((sum, [, , beats = 0.125]) => sum + beats, 0)
    const velocity = { x: word === FORWARD ? speed : 0, y: 0, z: 0, yaw: word === LEFT ? speed : 0 }
    return { start, end: start + beats, words: [word], velocity }
  })
}

/** `start-end` of each item. */
function spans(all, first = 0, last = all.length) {
  return itemsOf(all, first, last).map(({ start, end }) => `${start}-${end}`)
}

test("a word whose speed changes is one item", () => {
  assert.deepEqual(spans(segments([LEFT, 0.3], [LEFT, 1], [LEFT, 1.3, 0.5], [LEFT, 1], [LEFT, 0.3])), ["0-1"])
})

test("two words are two items, also at the same speed", () => {
  assert.deepEqual(spans(segments([LEFT, 1], [LEFT, 2], [FORWARD, 2], [FORWARD, 1])), ["0-0.25", "0.25-0.5"])
})

test("a word that is repeated is an item each time", () => {
  assert.deepEqual(spans(segments([LEFT, 1], [LEFT, 1])), ["0-0.125", "0.125-0.25"])
  assert.deepEqual(spans(segments([LEFT, 0.5], [LEFT, 1], [LEFT, 0.5], [LEFT, 0.5], [LEFT, 1])), ["0-0.375", "0.375-0.625"])
})

test("an item at the edge of the view is whole", () => {
  const all = segments([FORWARD, 1], [LEFT, 0.3], [LEFT, 1], [LEFT, 0.3], [FORWARD, 1])
  assert.deepEqual(spans(all, 2, 3), ["0.125-0.5"])
})

test("a bracket holds words whose speed changes", () => {
  const all = segments([FORWARD, 1], [LEFT, 0.3], [LEFT, 1], [LEFT, 0.3])
  const found = runs(itemsOf(all, 0, 4), new ProgramText(TEXT, WORDS), () => "a bracket")
  assert.deepEqual(found.map(({ start, end }) => [start, end]), [[0, 0.5]])
})

test("the outline follows the speed", () => {
  const [item] = itemsOf(segments([LEFT, 1], [LEFT, 3], [LEFT, 4, 0.5], [LEFT, 3], [LEFT, 1]), 0, 5)
  const [voice] = new ProgramText(TEXT, WORDS).voices(item)
  const points = outline(item, voice)
  assert.deepEqual(points[0], [0, 0])
  assert.deepEqual(points.at(-1), [1, 0])
  assert.deepEqual(points.filter(([, high]) => high === 1), [[0.3125, 1], [0.6875, 1]])
  assert.ok(outline(...evenly([LEFT, 2])).every(([, high]) => high === 1))
})

test("a voice that keeps its speed has an even outline beside one that doesn't", () => {
  const all = [1, 2, 1].map((yaw, i) => ({
    start: i, end: i + 1, words: [FORWARD, LEFT], velocity: { x: 5, y: 0, z: 0, yaw },
  }))
  const [item] = itemsOf(all, 0, 3)
  const [forward, left] = new ProgramText(TEXT, WORDS).voices(item)
  assert.ok(outline(item, forward).every(([, high]) => high === 1))
  assert.ok(outline(item, left).some(([, high]) => high < 0.6))
})

test("names stand where phrases begin, wherever the view begins", () => {
  const text = "square = repeat 4 (forward left)\nverse = square square forward\nada $ verse verse\n"
  const at = (word, from = 0) => [text.indexOf(word, from), text.indexOf(word, from) + word.length]
  const [one, other] = [at("verse", text.indexOf("$")), at("verse", text.lastIndexOf("verse"))]
  const [first, second] = [at("square", text.indexOf("verse")), at("square", text.lastIndexOf("square"))]
  const square = (names) => [0, 1, 2, 3].flatMap(() => [[...names, at("forward")], [...names, at("left")]])
  const end = at("forward", second[1])
  const verse = (name) => [...square([name, first]), ...square([name, second]), [name, end]]
  const velocity = { x: 1, y: 0, z: 0, yaw: 0 }
  const all = [...verse(one), ...verse(other)].map((words, start) => ({ start, velocity, words }))
  for (const from of [0, 12]) {
    const found = labels(all, from, 34, new ProgramText(text, WORDS)).map(({ start, text }) => `${start} ${text}`)
    assert.deepEqual(found, ["0 verse › square", "8 square", "17 verse › square", "25 square"])
  }
})

function evenly(...all) {
  const [item] = itemsOf(segments(...all), 0, all.length)
  return [item, new ProgramText(TEXT, WORDS).voices(item)[0]]
}

test("a pose is one voice of two words, also under a name", () => {
  const program = new ProgramText("r $ head wave to  high", WORDS)
  const pose = { velocity: { x: 0, y: 0, z: 2, yaw: 0 }, words: [[9, 13], [14, 22]] }
  const [{ word, at, rests, names }] = program.voices(pose)
  assert.deepEqual([word, at, rests, names], ["to  high", 14, false, [{ word: "wave", at: 9 }]])
  assert.deepEqual(program.wordStarts([14, 22]), [14, 18])
  assert.deepEqual(program.wordStarts([4, 8]), [4])
})

test("a word is lit with its measure", () => {
  const text = "r $ left 180deg radius 60cm forward side*1m left fast 2 forward"
  const words = new ProgramText(text, WORDS)
  const lit = (/** @type {number} */ at, /** @type {string} */ word) =>
    words.wordStarts([at, at + word.length]).map((start) => /^(?:[\d.]+|[a-z]+|.)/.exec(text.slice(start))?.[0])
  assert.deepEqual(lit(4, "left 180deg radius 60cm"), ["left", "180", "deg", "radius", "60", "cm"])
  assert.deepEqual(lit(28, "forward side*1m"), ["forward", "side", "*", "1", "m"])
  assert.deepEqual(lit(44, "left"), ["left"])
  const [{ word, sign }] = words.voices({ velocity: { x: 0, y: 0, z: 0, yaw: 3 }, words: [[4, 27]] })
  assert.deepEqual([word, sign], ["left 180deg radius 60cm", "↰"])
})
