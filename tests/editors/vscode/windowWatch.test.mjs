// When robots pause because a window that they may outlive no longer answers: editors/vscode/src/windowWatch.ts.

import assert from "node:assert/strict"
import { afterEach, beforeEach, test } from "node:test"
import { WindowWatch } from "../../../editors/vscode/src/windowWatch.ts"
import { answerNothing, asked, env, open, UIKind, warnings, window } from "./vscode.mjs"

const SECONDS_UNTIL_PAUSE = 6
const MINUTE = 60 // how often browsers let a hidden page answer

let watch

beforeEach((context) => {
  context.mock.timers.enable({ apis: ["setInterval"] })
  open()
  watch = new WindowWatch()
})

afterEach(() => watch.dispose())

/** What the window, and the server, have been asked for after some seconds, each with its answer. */
async function after(context, seconds) {
  for (let second = 0; second < seconds; second++) {
    context.mock.timers.tick(1000)
    await Promise.resolve()
  }
  return { pauses: asked.filter((each) => each === "improv.pause").length, all: asked.length, warnings: warnings.length }
}

test("robots pause once, with a line, after the window has answered nothing for seconds", async (context) => {
  watch.watch(true, false)
  assert.deepEqual(await after(context, 60), { pauses: 0, all: 60, warnings: 0 })
  answerNothing(true)
  watch.watch(true, false)
  assert.equal((await after(context, SECONDS_UNTIL_PAUSE - 1)).pauses, 0)
  assert.equal((await after(context, 1)).pauses, 1)
  assert.deepEqual(await after(context, 60), { pauses: 1, all: 127, warnings: 1 })
})

test("any answer counts, and the next silence pauses robots again", async (context) => {
  watch.watch(true, false)
  for (const pauses of [1, 2]) {
    answerNothing(true)
    assert.equal((await after(context, SECONDS_UNTIL_PAUSE)).pauses, pauses)
    answerNothing(false)
    await after(context, 1)
  }
})

test("the window is asked only while real robots may move", async (context) => {
  watch.watch(false, false)
  assert.equal((await after(context, 10)).all, 0)
  watch.watch(true, false)
  await after(context, 1)
  watch.watch(false, false)
  assert.equal((await after(context, 10)).all, 1)
})

test("a window that we end with is not asked", async (context) => {
  const asks = async (kind, remote) => {
    open()
    env.uiKind = kind
    env.remoteName = remote
    watch.watch(true, false)
    const { all } = await after(context, 1)
    watch.watch(false, false)
    return all > 0
  }
  assert.equal(await asks(UIKind.Desktop, undefined), false)
  assert.equal(await asks(UIKind.Desktop, "ssh-remote"), true)
  assert.equal(await asks(UIKind.Web, undefined), true)
})

for (const hasPage of [true, false]) {
  test(`a hidden window that answers once a minute pauses nothing, ${hasPage ? "with" : "without"} the page`, async (context) => {
    window.state.focused = false
    watch.watch(true, hasPage)
    for (let minute = 0; minute < 3; minute++) {
      answerNothing(true)
      assert.equal((await after(context, MINUTE)).pauses, 0)
      answerNothing(false)
      await after(context, 1)
    }
  })
}

test("without its page, a hidden window that has gone pauses robots after more than a minute", async (context) => {
  window.state.focused = false
  watch.watch(true, false)
  answerNothing(true)
  assert.equal((await after(context, 75)).pauses, 0)
  assert.equal((await after(context, 1)).pauses, 1)
})

test("robots pause seconds after a hidden window went with its page", async (context) => {
  window.state.focused = false
  watch.watch(true, true)
  answerNothing(true)
  assert.equal((await after(context, 10 * MINUTE)).pauses, 0)
  watch.watch(true, false)
  assert.equal((await after(context, SECONDS_UNTIL_PAUSE - 1)).pauses, 0)
  assert.equal((await after(context, 1)).pauses, 1)
})

test("a person who closes the page and then hides the window pauses nothing", async (context) => {
  watch.watch(true, true)
  watch.watch(true, false)
  await after(context, 1)
  window.state.focused = false
  answerNothing(true)
  assert.equal((await after(context, MINUTE)).pauses, 0)
})
