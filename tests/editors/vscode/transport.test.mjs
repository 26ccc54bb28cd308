// Which robots stand still, as in improv_core/stage/player.py: editors/vscode/src/transport.ts.

import assert from "node:assert/strict"
import { test } from "node:test"
import { isSilent } from "../../../editors/vscode/src/transport.ts"

const ROBOTS = ["one", "two", "three"]

function check(muted, soloed, silent) {
  assert.deepEqual(ROBOTS.filter((robot) => isSilent({ muted, soloed }, robot)), silent)
}

test("muted robots stand still, or where any are soloed, all others", () => {
  check([], [], [])
  check(["one"], [], ["one"])
  check([], ["two"], ["one", "three"])
  check(["one"], ["two"], ["one", "three"])
})

test("a robot that is muted and soloed plays", () => {
  check(["one", "two"], ["one"], ["two", "three"])
})
