// What one's own browser keeps on a website while links take its place: no text and no improv.toml is lost.

import assert from "node:assert/strict"
import { beforeEach, test } from "node:test"

import { Draft } from "../../../improv_core/page/static/editor/draft.js"
import { fragmentOf } from "../../../improv_core/page/static/website/link.js"
import { openProgram, storeProgram } from "../../../improv_core/page/static/website/local-program.js"

const OWN = { text: "ada $ forward\n", toml: "[robots.ada]\n" }

/** What a browser keeps, as long as it has room. */
class Storage {
  getItem(key) {
    return this[key] ?? null
  }
  setItem(key, value) {
    if (value.length > room) throw new Error("full")
    this[key] = value
  }
  removeItem(key) {
    delete this[key]
  }
}

let room = Infinity
let reloads = 0
let followLink

/** A browser in which nothing was opened yet. */
beforeEach(() => {
  room = Infinity
  reloads = 0
  Object.assign(globalThis, {
    localStorage: new Storage(),
    history: { replaceState: (_state, _title, to) => go(to) },
    addEventListener: (kind, does) => kind === "hashchange" && (followLink = does),
  })
})

function go(to) {
  const { pathname, search, hash } = new URL(to, "https://improv.example/here/")
  Object.assign(globalThis, { location: { pathname, search, hash, reload: () => reloads++ } })
}

/** Opens a page in a tab of its own, by a link that holds this. */
async function openTab(work = null, tab = {}) {
  Object.assign(globalThis, { sessionStorage: Object.assign(new Storage(), tab) })
  go(`/here/${work ? await fragmentOf({ ...work, beat: 0, still: [] }) : ""}`)
  const { program, problem } = await openProgram()
  const draft = new Draft({ path: "dance.improv", text: program.text, revision: program.revision })
  const text = draft.begin(program.toml)
  draft.keep({ text, toml: program.toml })
  return { program, problem, draft, text }
}

/** All that can be had instead of what is on a page, in the order in which it is offered. */
function offered(draft, shown) {
  const found = []
  for (let work = draft.swap(shown); work.text !== shown.text || work.toml !== shown.toml; work = draft.swap(work)) {
    found.push({ text: work.text, toml: work.toml })
    if (found.length > 20) break
  }
  return found
}

/** What somebody has written and saved. */
const save = (work, revision) => storeProgram({ ...work, revision: String(revision) })

test("one's own text and improv.toml stay however many links are opened, in new tabs or in one", async () => {
  for (const tab of [{}, { "improv.tab": "one" }]) {
    localStorage.removeItem("improv.draft.one")
    save(OWN, 1)
    let page = await openTab()
    for (let number = 1; number <= 5; number++) page = await openTab({ text: `bo $ left # ${number}`, toml: `# ${number}` }, tab)
    assert.deepEqual(offered(page.draft, page.program), [OWN])
    page = await openTab(null, tab)
    assert.equal(page.text, "bo $ left # 5")
    assert.deepEqual(offered(page.draft, page.program), [OWN])
  }
})

test("what is written between two links stays, too", async () => {
  save(OWN, 1)
  const own = [OWN]
  let page = await openTab()
  for (let number = 1; number <= 3; number++) {
    page = await openTab({ text: `bo $ left # ${number}`, toml: "" }, { "improv.tab": "one" })
    own.unshift({ text: `ada $ right # ${number}`, toml: `# ${number}` })
    save(own[0], Number(page.program.revision) + 1)
    page.draft.keep({ text: "not saved", toml: "" }) // so that the tab has something of its own
  }
  page = await openTab({ text: "last", toml: "" }, { "improv.tab": "two" })
  const found = offered(page.draft, page.program)
  for (const each of own) assert.ok(found.some((other) => other.text === each.text && other.toml === each.toml), each.text)
})

test("a text that was never saved comes back in a new tab, unless a link or a save has come since", async () => {
  const closed = await openTab(null, { "improv.tab": "one" })
  closed.draft.keep({ text: "cy $ left", toml: "" })
  const again = await openTab(null, { "improv.tab": "two" })
  assert.equal(again.text, "cy $ left")
  assert.equal(again.draft.other({ text: "cy $ left # longer", toml: "" }), null) // nothing else is offered
  const linked = await openTab(OWN, { "improv.tab": "three" })
  assert.equal(linked.text, OWN.text)
  assert.ok(offered(linked.draft, linked.program).some(({ text }) => text === "cy $ left"))
  save(OWN, 9)
  const saved = await openTab(null, { "improv.tab": "four" })
  assert.equal(saved.text, OWN.text)
})

test("an improv.toml stays though the link has the same text", async () => {
  save(OWN, 1)
  const { draft, program } = await openTab({ text: OWN.text, toml: "# other" })
  assert.deepEqual(offered(draft, program), [OWN])
})

test("a link to what is one's own replaces nothing", async () => {
  save(OWN, 1)
  const same = await openTab(OWN)
  assert.equal(same.draft.other(same.program), null)
  const { draft, program } = await openTab({ text: "bo $ left", toml: "" })
  assert.deepEqual(offered(draft, program), [OWN])
})

test("who keeps an unsaved text, and not that of a link, keeps its improv.toml", async () => {
  save(OWN, 1)
  const tab = { "improv.tab": "one" }
  const before = await openTab(null, tab)
  before.draft.keep({ text: "mine", toml: OWN.toml })
  const { draft, text } = await openTab({ text: "theirs", toml: "# theirs" }, tab)
  assert.equal(text, "mine")
  const shown = draft.choose("mine", { text, toml: "# theirs" })
  assert.deepEqual(shown, { text: "mine", toml: OWN.toml })
  assert.ok(offered(draft, { text: "mine", toml: OWN.toml }).some(({ toml }) => toml === "# theirs"))
})

test("without room, one's own stays where it is", async () => {
  save(OWN, 1)
  room = 10
  const { program, problem } = await openTab({ text: "bo $ left", toml: "" })
  assert.match(problem, /no room for another dance/)
  assert.deepEqual([program.text, program.toml], [OWN.text, OWN.toml])
})

test("what a link has replaced stays until the page keeps it", async () => {
  save(OWN, 1)
  await openTab()
  go(`/here/${await fragmentOf({ text: "bo $ left", toml: "", beat: 0, still: [] })}`)
  const { program } = await openProgram()
  room = 10
  const draft = new Draft({ path: "dance.improv", text: program.text, revision: program.revision })
  draft.begin("")
  draft.keep({ text: program.text, toml: "" })
  assert.equal(draft.isKept, false)
  room = Infinity
  const later = await openTab()
  assert.deepEqual(offered(later.draft, later.program), [OWN])
})

test("a link that is opened where a page is open already opens it anew", async () => {
  await openTab()
  await followLink?.()
  assert.equal(reloads, 0)
  go(`/here/${await fragmentOf({ ...OWN, beat: 0, still: [] })}`)
  await followLink?.()
  assert.equal(reloads, 1)
})
