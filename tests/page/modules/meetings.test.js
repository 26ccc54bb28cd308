// Marks where robots will meet: what they say, and which one is under the pointer.

import assert from "node:assert/strict"
import test from "node:test"

import { Meetings } from "../../../improv_core/page/static/floor/meetings.js"

const CAMERA = { view: { x: 0, y: 0, scale: 100 }, toScreen: ({ x, y }) => ({ x: 100 * x, y: -100 * y }) }
const MESSAGE = {
  generation: 3,
  meetings: [{ robots: ["ada", "bo"], beat: 6.5, distance: 0.12, more: 2, poses: [[0, 1, 0, 0], [0, 2, 0, 0]] }],
  hits: [{ robot: "ada", thing: "edge", beat: 2.25, pose: [2, 0, 0, 0] }],
}

/** Meetings with their button, and the beats to which it has sought. */
function meetings() {
  const page = { beat: 0, sought: [], button: { addEventListener: (_, press) => (page.press = press) } }
  page.meetings = new Meetings(page.button, (beat) => page.sought.push((page.beat = beat)), () => page.beat)
  page.meetings.take(MESSAGE)
  return page
}

test("they are said in their order, in beats or bars that count from 1", () => {
  const page = meetings()
  assert.deepEqual(page.meetings.show(3, null).map(({ words }) => words), [
    "beat 3: ada hits the edge of the floor",
    "beat 7: ada and bo meet, 0.12 m apart, and 2 times more",
  ])
  assert.equal(page.meetings.show(3, 3)[1].words, "bar 3, beat 1: ada and bo meet, 0.12 m apart, and 2 times more")
  assert.deepEqual([page.button.hidden, page.button.textContent], [false, "2 meetings ahead"])
})

test("the button counts only those that are still ahead, and the robots being where they meet counts", () => {
  const page = meetings()
  page.meetings.show(3, null)
  const texts = [2.25, 2.3, 6.5, 6.6, 0].map((beat) => {
    page.beat = beat
    page.meetings.showAhead()
    return page.button.hidden ? "" : page.button.textContent
  })
  assert.deepEqual(texts, ["2 meetings ahead", "1 meeting ahead", "1 meeting ahead", "", "2 meetings ahead"])
})

test("those of another score are not shown", () => {
  const page = meetings()
  assert.deepEqual(page.meetings.show(4, null), [])
  assert.deepEqual([page.button.hidden, page.meetings.marks(CAMERA)], [true, []])
})

test("the button leads from one to the next, and around", () => {
  const page = meetings()
  page.meetings.show(3, null)
  for (let i = 0; i < 3; i++) page.press()
  assert.deepEqual(page.sought, [2.25, 6.5, 2.25])
})

test("a mark stands between its robots, and is under a pointer nearby", () => {
  const { meetings: all } = meetings()
  all.show(3, null)
  assert.deepEqual(all.marks(CAMERA).map(({ place, shows }) => [place, shows]), [[{ x: 200, y: 0 }, true], [{ x: 0, y: -150 }, true]])
  assert.equal(all.at({ x: 5, y: -145 }, CAMERA).beat, 6.5)
  assert.equal(all.at({ x: 100, y: 0 }, CAMERA), null)
})

test("of many, only the one that is pointed at is drawn with its robots", () => {
  const { meetings: all } = meetings()
  all.take({ ...MESSAGE, hits: Array.from({ length: 30 }, (_, beat) => ({ ...MESSAGE.hits[0], beat })) })
  const pointed = (all.pointed = all.show(3, null)[4])
  assert.deepEqual(all.marks(CAMERA).filter(({ shows }) => shows).map(({ meeting }) => meeting), [pointed])
})
