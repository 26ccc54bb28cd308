// A program as a link.

import assert from "node:assert/strict"
import { test } from "node:test"
import { deflateRawSync } from "node:zlib"

import { BROKEN, LATER, STRANGE, fragmentOf, isTooLong, workIn } from "../../../improv_core/page/static/website/link.js"

/** A link that holds this. */
const link = (held) => `#dance=${deflateRawSync(typeof held === "string" ? held : JSON.stringify(held)).toString("base64url")}`

test("a link holds the program, its improv.toml, and the beat", async () => {
  for (const work of [
    { text: "ada $ forward\n", toml: "", beat: 0 },
    { text: "fünf = (left) # 🐢\nada $ fünf\n", toml: "[world]\nsize = [4, 4]\n", beat: 7.5 },
    { text: "ada $ left # \u0645\u06cc\u200c\u0631\u0642\u0635\u062f 👩‍👧\n", toml: "", beat: 0 }, // what joins letters and pictures shows
    { text: "", toml: "", beat: 0 },
  ]) {
    const fragment = await fragmentOf(work)
    assert.match(fragment, /^#dance=[\w-]+$/)
    assert.deepEqual(await workIn(fragment), work)
  }
})

test("a link that a program has encoded once more on its way is opened", async () => {
  const work = { text: "ada $ forward\n", toml: "", beat: 0 }
  const fragment = await fragmentOf(work)
  for (const equals of ["%3D", "%3d", "%253D"]) assert.deepEqual(await workIn(fragment.replace("=", equals)), work)
})

test("other fragments are not links", async () => {
  for (const fragment of ["", "#", "#top", "#dance", "#%", "#100%3D"]) assert.equal(await workIn(fragment), null)
})

test("what isn't a dance is not opened, and one line says so", async () => {
  const whole = await fragmentOf({ text: "ada $ repeat 4 (forward left)", toml: "", beat: 0 })
  const rows = [
    [whole.slice(0, -9), BROKEN],
    ["#dance=!!!", BROKEN],
    [link("no JSON"), BROKEN],
    [link({ v: 2, text: "ada $ forward" }), LATER],
    [link({ text: "ada $ forward" }), STRANGE],
    [link({ v: 1, text: 7 }), STRANGE],
    [link({ v: 1, text: "ada", beat: -1 }), STRANGE],
    [link([]), STRANGE],
    [link({ v: 1, text: "x".repeat(5_000_000) }), STRANGE],
    [link({ v: 1, text: "ada $ \u202Edrawrof" }), STRANGE],
    [link({ v: 1, text: "ada $ for\u0007ward" }), STRANGE],
  ]
  for (const [fragment, line] of rows) assert.equal(await workIn(fragment), line, fragment.slice(0, 40))
})

test("a long dance is no link", async () => {
  const text = Array.from({ length: 3000 }, (_, number) => `r${number} $ forward ${Math.sin(number)}\n`).join("")
  assert.ok(isTooLong(await fragmentOf({ text, toml: "", beat: 0 })))
  assert.ok(!isTooLong(await fragmentOf({ text: "ada $ repeat 4 (forward left)\n", toml: "", beat: 0 })))
})
