// The view: it comes to rest, keeps room for a while, and then gives it up at once.

import assert from "node:assert/strict"
import test from "node:test"

import { Camera } from "../../../improv_core/page/static/floor/camera.js"

const FRAME = 1 / 60 // seconds
const square = (size) => [{ x: 0, y: 0 }, { x: size, y: size }]

/** Shows a square for so many seconds. Returns the number of frames in which the view moved. */
function show(camera, size, seconds) {
  return Array.from({ length: seconds / FRAME }, () => camera.follow(square(size), 0.2, FRAME)).filter(Boolean).length
}

function opened() {
  const camera = new Camera()
  camera.size = { width: 800, height: 600 }
  show(camera, 40, 5)
  return camera
}

test("a small dance after a wide one moves the view once, after eight seconds, for less than four", () => {
  const camera = opened()
  const wide = camera.sight
  assert.equal(show(camera, 4, 7.9), 0)
  assert.equal(camera.sight, wide)
  const moved = show(camera, 4, 30)
  assert.ok(moved > 0 && moved < 4 / FRAME, `${moved} frames`)
  assert.ok(camera.sight.scale > 5 * wide.scale)
})

test("a dance that is played again within eight seconds keeps the view", () => {
  const camera = opened()
  for (const size of [4, 40, 4, 40]) assert.equal(show(camera, size, 5), 0)
})

test("Fit needs no eight seconds", () => {
  const camera = opened()
  camera.fit()
  assert.ok(show(camera, 4, 3) > 0)
  assert.ok(camera.toScreen({ x: 4, y: 4 }).x - camera.toScreen({ x: 0, y: 0 }).x > 300)
})
