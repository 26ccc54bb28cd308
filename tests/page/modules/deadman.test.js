// The deadman button of a gamepad: what is sent while it is held, and when it counts as released.

import assert from "node:assert/strict"
import test from "node:test"

import { sendBy } from "../../../improv_core/page/static/net/send.js"
import { Deadman } from "../../../improv_core/page/static/controls/deadman.js"

const HOLD = "hold button 4 to move"
globalThis.HTMLElement = class {}

/** A page that moves robots only while button 4 is held: its line, what it has sent, and its gamepad. */
function opened() {
  const [line, sent] = [new HTMLElement(), []]
  const pad = { connected: true, buttons: [0, 1, 2, 3, 4, 5].map(() => ({ pressed: false })) }
  globalThis.document = Object.assign(new EventTarget(), { hidden: false, getElementById: () => line })
  gamepads(() => [null, pad])
  sendBy(({ type }) => sent.push(type))
  const deadman = new Deadman()
  deadman.require({ button: 4 })
  return { line, sent, pad, deadman }
}

/** What the browser answers when it is asked for gamepads. */
function gamepads(getGamepads) {
  Object.defineProperty(globalThis, "navigator", { value: { getGamepads }, configurable: true })
}

/** What a browser does in a frame that may not see gamepads. */
function refuse() {
  throw new DOMException("not allowed", "SecurityError")
}

/** The milliseconds of frames from one time up to another. */
const frames = (from, to) => Array.from({ length: (to - from) / 10 }, (_, number) => from + 10 * number)

test("another button moves nobody", () => {
  const { line, sent, pad, deadman } = opened()
  pad.buttons[3].pressed = true
  for (const now of frames(5000, 5300)) deadman.look(now)
  assert.deepEqual([line.hidden, line.textContent, sent], [false, HOLD, []])
})

test("messages that it is held are a tenth of a second apart, and one says that it is released", () => {
  const { line, sent, pad, deadman } = opened()
  for (const pressed of [true, false, true]) {
    pad.buttons[4].pressed = pressed
    for (const now of frames(5000, 5300)) deadman.look(now)
    assert.equal(line.hidden, pressed)
  }
  assert.deepEqual(sent, ["held", "held", "held", "released", "held", "held", "held"])
})

const GONE = {
  "a gamepad that is unplugged": (pad) => (pad.connected = false),
  "a gamepad that has disappeared": () => gamepads(() => [null, null]),
  "a page that is hidden": () => (document.hidden = true),
  "a frame that may no longer see gamepads": () => gamepads(refuse),
}
for (const [what, happen] of Object.entries(GONE)) {
  test(`${what} counts as released`, () => {
    const { line, sent, pad, deadman } = opened()
    pad.buttons[4].pressed = true
    deadman.look(5000)
    happen(pad)
    document.dispatchEvent(new Event("visibilitychange")) // a hidden page draws no frames
    assert.deepEqual([sent, line.hidden], [["held", "released"], false])
  })
}

test("a frame that may not see gamepads says what to do", () => {
  const { line, deadman } = opened()
  gamepads(refuse)
  deadman.look(5000)
  assert.equal(line.textContent, "open this page in a browser to use a gamepad")
})

test("if no button is required, nothing is shown and nothing sent", () => {
  const { line, sent, pad, deadman } = opened()
  deadman.require(null)
  pad.buttons[4].pressed = true
  for (const now of frames(5000, 5300)) deadman.look(now)
  assert.deepEqual([line.hidden, sent], [true, []])
})
