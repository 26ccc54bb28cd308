// Frames: asked for while something changes, and not otherwise.

import assert from "node:assert/strict"
import test from "node:test"

/** A browser that draws no frame and lets no time pass by itself. */
async function opened(frame) {
  const asked = []
  const timers = new Map()
  globalThis.window = globalThis
  globalThis.requestAnimationFrame = (then) => asked.push(then)
  globalThis.document = { hidden: false }
  const delays = []
  globalThis.setTimeout = (then, delay = 0) => (delays.push(delay), timers.set(timers.size + 1, then).size)
  globalThis.clearTimeout = (timer) => timers.delete(timer)
  const frames = await import(`../../../improv_core/page/static/base/frames.js?${Math.random()}`)
  frames.showFrames(frame)
  /** Draws the frames that are asked for. Returns how many those are. */
  const draw = () => asked.splice(0).map((then) => then()).length
  /** Lets the time pass that a page at rest waits. */
  const rest = () => [...timers].map(([timer, then]) => timers.delete(timer) && then()).length
  return { ...frames, draw, rest, delays }
}

test("a page asks for another frame while something moves, and for none at rest", async (context) => {
  const { setTimeout, clearTimeout } = globalThis
  context.after(() => Object.assign(globalThis, { setTimeout, clearTimeout }))
  let [looks, moves] = [0, true]
  const { draw, rest, redraw, due } = await opened(() => (looks++, (due.draw = false), moves))
  assert.deepEqual([draw(), draw(), draw(), looks], [1, 1, 1, 3])
  moves = false
  assert.deepEqual([draw(), draw()], [1, 0])
  assert.deepEqual([rest(), draw(), looks], [1, 0, 5]) // it looks, but asks the browser for nothing
  redraw()
  redraw()
  assert.deepEqual([due.draw, draw(), looks, due.draw], [true, 1, 6, false])
  globalThis.document.hidden = true
  assert.deepEqual([rest(), rest(), looks], [1, 0, 6]) // a hidden page does not even look
})

test("while somebody writes, a long frame waits until its key is shown, and is followed by a break of eight times that", async (context) => {
  const { setTimeout, clearTimeout } = globalThis
  context.after(() => Object.assign(globalThis, { setTimeout, clearTimeout }))
  let [now, takes] = [5000, 30]
  context.mock.method(performance, "now", () => now)
  const { draw, rest, redraw, redrawPaths, makeWay, due, delays } = await opened(() => ((now += takes), false))
  draw() // 30 ms: from now on, keys come first
  now += 300
  makeWay()
  redraw()
  assert.deepEqual([draw(), delays.at(-1)], [0, 50])
  now += 50
  assert.deepEqual([rest(), draw(), rest()], [2, 1, 1])
  redraw() // during the break
  assert.deepEqual([draw(), delays.at(-1)], [0, 240])
  now += 220
  makeWay() // another key
  now += 20
  assert.deepEqual([rest(), draw(), delays.at(-1)], [2, 0, 30])
  now += 30
  rest() // the browser is asked for a frame, but before it comes,
  makeWay() // there is a key
  assert.deepEqual([draw(), draw(), delays.at(-1)], [1, 0, 50])
  now += 50
  takes = 300
  assert.deepEqual([rest(), draw(), rest()], [1, 1, 1])
  redraw()
  assert.deepEqual([draw(), delays.at(-1)], [0, 400])
  now += 390
  makeWay() // once more
  now += 10
  assert.deepEqual([rest(), draw(), delays.at(-1)], [2, 0, 40])
  now += 180
  makeWay() // but no longer than for 600 ms
  now += 5
  assert.deepEqual([rest(), draw(), delays.at(-1)], [1, 0, 15])
  redrawPaths() // somebody waits for these
  assert.deepEqual([draw(), rest()], [1, 1])
  due.paths = false
  takes = 12
  makeWay()
  now += 450
  redraw()
  assert.deepEqual([draw(), rest()], [1, 1])
  redraw()
  assert.deepEqual([draw(), delays.at(-1)], [0, 96])
  now += 96
  assert.deepEqual([rest(), draw(), rest()], [2, 1, 1])
  takes = 8 // keys need not wait for that
  now += 400
  redraw()
  assert.deepEqual([draw(), rest()], [1, 1])
  makeWay()
  redraw()
  assert.equal(draw(), 1)
  takes = 30
  rest()
  now += 2000 // nobody writes any more
  redraw()
  draw()
  redraw()
  assert.equal(draw(), 1)
})
