// What VS Code would turn into a link in a notification: editors/vscode/src/messages.ts.

import assert from "node:assert/strict"
import { test } from "node:test"
import { withoutLinks } from "../../../editors/vscode/src/messages.ts"

/** What VS Code 1.100 looks for in a notification, after it has replaced line breaks with spaces. */
const LINK = /\[([^\]]+)\]\(((?:https?:\/\/|command:|file:)[^\)\s]+)(?: (["'])(.+?)(\3))?\)/i

function links(text) {
  return LINK.test(text.replaceAll(/\r\n|\n|\r/g, " "))
}

for (const linked of [
  "[x](command:workbench.action.terminal.new)",
  "improv.onSave: got '[x](COMMAND:quit)'",
  "[x](https://example.org)",
  "[x](file:///etc/passwd 'a title')",
  "[[x](command:quit)",
  "[a](b [x](command:quit)",
  "[x](command:quit)[y](command:quit)",
]) {
  test(`no link is left of ${linked}`, () => {
    assert.ok(links(linked))
    assert.ok(!links(withoutLinks(linked)))
  })
}

test("all else stays as it is", () => {
  for (const text of ["[forward left] (up)", "turtle1 $ (left)", "/path [1]/bin", "]\n("]) {
    assert.equal(withoutLinks(text), text)
    assert.ok(!links(text))
  }
})
