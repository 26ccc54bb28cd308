// Trails while somebody scrubs: what the server tells of a seek arrives in pieces, with frames between them.

import assert from "node:assert/strict"
import test from "node:test"

import { Lookahead } from "../../../improv_core/page/static/score/lookahead.js"
import { Motion } from "../../../improv_core/page/static/floor/motion.js"
import { poseAfter } from "../../../improv_core/page/static/base/path.js"
import { Trails } from "../../../improv_core/page/static/floor/trails.js"

const AT = 5 // seconds of performance, which stand while it is paused

/** What is known of `r $ repeat 8 (forward left forward right)`, a staircase: all of its lines are upright or level. */
function staircase() {
  const lookahead = new Lookahead({ generation: 1, tempo: 60, beats: 32, text: "", words: {}, robots: { r: { ends: 32 } }, offsets: {} }, () => {})
  const turns = [[2, 0], [0, Math.PI / 2], [2, 0], [0, -Math.PI / 2]]
  const moments = Array.from({ length: 32 }, (_, beat) => [beat, 1, turns[beat % 4][0], 0, 0, turns[beat % 4][1], []])
  lookahead.want(0)
  lookahead.take({ generation: 1, from: 0, to: 32, robots: { r: { pose: [0, 0, 0, 0], moments, body: {}, until: 32 } } })
  return lookahead
}

/** A page that is paused at beat 0, and what the server tells it of each of several seeks: on three ways. */
class Scrubbed {
  #lookahead = staircase()
  #motion = new Motion()
  #trails = new Trails()

  constructor() {
    for (const tell of this.seek(0, 0)) tell()
  }

  seek(beat, placed) {
    const { x, y, z, heading } = this.#lookahead.poseAt("r", beat)
    return [
      () => this.#trails.seek(beat, { r: { x, y, z, heading } }),
      () => this.#motion.take({ at: AT, placed, poses: { r: [x, y, z, heading] }, joints: {} }, 100),
      () => this.#trails.take({ placed, robots: { r: { from: 0, places: [[AT, x, y, heading]] } } }),
    ]
  }

  /** The ends of the lines that a frame draws. */
  frame() {
    const { at, placed, robots } = this.#motion.present(100)
    this.#trails.show(placed)
    this.#trails.complete(this.#lookahead)
    return [...this.#trails.segments("r", -Infinity, at, robots.r)].map(({ pose, velocity }) => [pose, poseAfter(pose, velocity, 1)])
  }
}

/** Every order in which lists can be merged that keeps each list's own. */
function* merges(lists) {
  if (lists.every((list) => !list.length)) yield []
  for (const [i, [first, ...rest]] of lists.entries()) {
    if (first === undefined) continue
    for (const others of merges(lists.with(i, rest))) yield [first, ...others]
  }
}

test("the room of a trail that another replaces is not kept", () => {
  const trails = new Trails()
  trails.take({ placed: 0, robots: { r: { from: 0, places: [[0, 0, 0, 0], [9, 90, 0, 0]] } } })
  assert.equal(trails.room[1].x, 90)
  trails.take({ placed: 0, robots: { r: { from: 0, places: [[0, 1, 0, 0]] } } })
  assert.deepEqual(trails.room, [{ x: 1, y: 0 }, { x: 1, y: 0 }])
})

test("no frame draws a way between two places of a seek, in whatever order it is told", () => {
  let frames = 0
  for (const order of merges([0, 1, 2].map((way) => [[0, way], [1, way]]))) {
    const page = new Scrubbed()
    const seeks = [page.seek(21.5, 1), page.seek(6.5, 2)]
    for (const [seek, way] of order) {
      seeks[seek][way]()
      frames++
      for (const [from, to] of page.frame()) {
        const slants = Math.abs(to.x - from.x) > 0.01 && Math.abs(to.y - from.y) > 0.01
        assert.ok(!slants, `${JSON.stringify([from, to])} after ${order}`)
      }
    }
    const lines = page.frame()
    assert.ok(Math.abs(lines[0][0].x) + Math.abs(lines[0][0].y) < 1e-9, "the trail leads from the start")
    assert.ok(Math.abs(lines.at(-1)[1].x - 4) < 1e-6 && Math.abs(lines.at(-1)[1].y - 3) < 2, "to where the robot is")
  }
  assert.equal(frames, 90 * 6)
})
