// A program as a link.

import assert from "node:assert/strict"
import { test } from "node:test"
import { deflateRawSync } from "node:zlib"

import { BROKEN, LATER, STRANGE, fragmentOf, isTooLong, workIn } from "../../../improv_core/page/static/website/link.js"
import { stillOf } from "../../../improv_core/page/static/website/still.js"

/** A link that holds this. */
const link = (held) => `#dance=${deflateRawSync(typeof held === "string" ? held : JSON.stringify(held)).toString("base64url")}`

test("a link holds the program, its improv.toml, and the beat", async () => {
  for (const work of [
    { text: "ada $ forward\n", toml: "", beat: 0, still: [] },
    { text: "fünf = (left) # 🐢\nada $ fünf\n", toml: "[world]\nsize = [4, 4]\n", beat: 7.5, still: [[0, 0, 400, 400, 0], [1, 5, 6]] },
    { text: "ada $ left # \u0645\u06cc\u200c\u0631\u0642\u0635\u062f 👩‍👧\n", toml: "", beat: 0, still: [] }, // what joins letters and pictures shows
    { text: "", toml: "", beat: 0, still: [] },
  ]) {
    const fragment = await fragmentOf(work)
    assert.match(fragment, /^#dance=[\w-]+$/)
    assert.deepEqual(await workIn(fragment), work)
  }
})

test("a link whose picture is none opens without it", async () => {
  for (const still of [7, [7], [[0, 1]], [[0, 1, 2.5]], [[0, 1, '"/><script>']]]) {
    assert.deepEqual((await workIn(link({ v: 1, text: "ada", still }))).still, [], String(still))
  }
})

test("the paths of robots become a picture of few numbers", () => {
  const square = [0, 1, 1, 0, 0].map((x, i) => ({ x, y: [0, 0, 1, 1, 0][i] }))
  assert.deepEqual(stillOf([[square], [[{ x: 0.5, y: 0.5 }]]]), [[0, 0, 400, 400, 0, 0, -400, -400, 0, 0, 400], [1, 200, 200]])
  assert.deepEqual(stillOf([[Array.from({ length: 400 }, (_, x) => ({ x, y: 0 }))]]), [])
})

test("a link that a program has encoded once more on its way is opened", async () => {
  const work = { text: "ada $ forward\n", toml: "", beat: 0, still: [] }
  const fragment = await fragmentOf(work)
  for (const equals of ["%3D", "%3d", "%253D"]) assert.deepEqual(await workIn(fragment.replace("=", equals)), work)
})

test("other fragments are not links", async () => {
  for (const fragment of ["", "#", "#top", "#dance", "#%", "#100%3D"]) assert.equal(await workIn(fragment), null)
})

test("what isn't a dance is not opened, and one line says so", async () => {
  const whole = await fragmentOf({ text: "ada $ repeat 4 (forward left)", toml: "", beat: 0, still: [] })
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
  assert.ok(isTooLong(await fragmentOf({ text, toml: "", beat: 0, still: [] })))
  assert.ok(!isTooLong(await fragmentOf({ text: "ada $ repeat 4 (forward left)\n", toml: "", beat: 0, still: [] })))
})
