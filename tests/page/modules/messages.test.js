// What the server should not say.

import assert from "node:assert/strict"
import test from "node:test"

import { read } from "../../../improv_core/page/static/net/messages.js"

test("a message that fits is read", () => {
  const poses = { type: "poses", at: 0, placed: 0, poses: [[0, 0, 0, 0]], joints: { ada: [0.5] } }
  assert.deepEqual(read(JSON.stringify(poses)), poses)
})

test("a message that does not fit is dropped", () => {
  for (const text of [
    "", "{", "7", "null", "[]", "{}", '{"type":"constructor"}',
    '{"type":"poses","at":0,"placed":0,"poses":[[0,0,0]],"joints":{}}',
    '{"type":"poses","at":0,"placed":0,"poses":{"ada":[0,0,0,0]},"joints":{}}',
    '{"type":"poses","at":null,"placed":0,"poses":[],"joints":{}}', '{"type":"poses","at":0,"poses":[],"joints":{}}', '{"type":"poses","at":0,"placed":0,"poses":[],"joints":{"ada":[null]}}',
    '{"type":"trails","robots":{}}', '{"type":"transport","generation":1,"state":"dancing"}',
    '{"type":"robots","robots":[]}', '{"type":"bumps","bumps":[{}]}',
    '{"type":"window","generation":1,"from":0,"to":1,"robots":{"ada":{"pose":null,"moments":[[0]],"until":1}}}',
  ]) assert.equal(read(text), null, text)
})
