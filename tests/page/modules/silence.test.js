// What a click on Mute or Solo asks for, also before the stage has answered the click before it.

import assert from "node:assert/strict"
import test from "node:test"

import { Silence } from "../../../improv_core/page/static/score/silence.js"

const told = (muted, soloed = []) => ({ muted, soloed })

test("a click flips what the latest message says", () => {
  const silence = new Silence()
  silence.take(told(["ada"], ["bo"]))
  assert.deepEqual(silence.flip("muted", "bo"), told(["ada", "bo"], ["bo"]))
  silence.take(told(["ada", "bo"], ["bo"]))
  assert.deepEqual(silence.flip("muted", "ada"), told(["bo"], ["bo"]))
})

test("a second click before the answer to the first keeps what the first asked for", () => {
  const silence = new Silence()
  silence.take(told(["ada"], ["ada"]))
  assert.deepEqual(silence.flip("muted", "ada"), told([], ["ada"]))
  assert.deepEqual(silence.flip("soloed", "ada"), told([]))
  silence.take(told([], ["ada"])) // the answer to the first
  assert.deepEqual(silence.flip("muted", "bo"), told(["bo"]))
})

test("what somebody else has changed counts at the next click", () => {
  const silence = new Silence()
  silence.flip("muted", "ada")
  silence.take(told(["cy"]))
  assert.deepEqual(silence.flip("muted", "bo"), told(["cy", "bo"]))
})
