// The view: it comes to rest, keeps room for a while, and then gives it up at once. Fit gives it up now.

import assert from "node:assert/strict"
import test from "node:test"

import { Camera } from "../../../improv_core/page/static/floor/camera.js"

const FRAME = 1 / 60 // seconds
const square = (size) => [{ x: 0, y: 0 }, { x: size, y: size }]

/** Shows a square for so many seconds. Returns the number of frames in which the view moved. */
function show(camera, size, seconds, frame = FRAME) {
  return Array.from({ length: seconds / frame }, () => camera.follow(square(size), 0.2, frame)).filter(Boolean).length
}

/** The part of the stage's height that a square takes. */
const share = (camera, size) => (size * camera.sight.scale) / camera.size.height

function opened(width = 800, height = 600) {
  const camera = new Camera()
  camera.size = { width, height }
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

for (const frame of [FRAME, 1 / 3]) {
  for (const change of ["fit", "forget"]) {
    test(`a small dance fills the stage a second after ${change}, also in frames of ${frame.toFixed(2)} s, and if it arrives late`, () => {
      const camera = opened()
      camera[change]()
      show(camera, 40, 2 / 3, frame) // the paths of before
      show(camera, 4, 1, frame)
      assert.ok(share(camera, 4) > 0.5, `${share(camera, 4)}`)
    })
  }
}

test("Fit fits where the view is still, too", () => {
  const camera = opened()
  show(camera, 10, 1)
  camera.fit()
  camera.follow(square(20), 0.2, Infinity)
  assert.ok(share(camera, 20) > 0.6)
})

test("a dance fills a phone's low stage as it fills a large one", () => {
  const [large, low] = [opened(1280, 700), opened(390, 300)]
  assert.ok(share(low, 40) > share(large, 40) - 0.03, `${share(low, 40)}`)
})
