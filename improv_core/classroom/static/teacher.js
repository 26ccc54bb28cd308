// @ts-check
// The teacher's page: the dances of a class, small; one in front; several together; and a stop for everything.

import { button, download, element, find, findA, svgAddress } from "/base/elements.js"
import { isOpen } from "/base/keys.js"
import { store, stored } from "/base/storage.js"
import { when } from "/base/when.js"

/** @typedef {{ count: number, sent: number, ok: boolean | null, line: string, picture: string }} Sent a dance; `sent` in seconds since 1970 */
/** @typedef {{ type: "child", number: number, name: string, here: boolean, latest: Sent | null, good: Sent | null }} Child */
/** @typedef {Child | { type: "gone", number: number } | { type: "robots", names: string[] } | { type: "playing", line: string } | { type: "keeping", folder: string, problem: string }} Message */
/** @typedef {{ child: Child, since: number, item: HTMLLIElement, box: HTMLInputElement, show: () => void }} Card a child, and when this page has first shown it */

const KEY = "improv.class.token"
const TICKS = "improv.class.ticks"
const SAME_LESSON = 3 * 3600_000 // milliseconds
const AGAIN = 100 // milliseconds until a stop that did not arrive is sent again
const TRIES = 50
const NOTICE_DELAY = 300 // milliseconds after which the page shows that a stop is not answered
const SILENT = 300 // seconds without a dance after which a child may need help
const LOOK = 15_000 // milliseconds
const SMALL = "<style>text { display: none } g, path { stroke-width: 6px }</style>" // no letter can be read in a small picture
const HIDDEN = /[^\P{C}\n\t]|[^\P{Z} ]/gu // what shows nothing, or turns text
const given = findA("token", HTMLMetaElement).content
if (given) sessionStorage.setItem(KEY, given)
const token = given || (sessionStorage.getItem(KEY) ?? "")
if (location.search) history.replaceState(null, "", location.pathname)

/** @type {Map<number, Card>} */
const cards = new Map()
/** @type {Set<number>} */
const chosen = new Set()
const earlier = new Set(earlierTicks()) // of children who haven't appeared yet
/** @type {{ child: Child, dance: Sent } | undefined} */
let front // as it was looked at: another dance that the child sends meanwhile doesn't take its place
/** @type {string | null} */
let frontText = null // as the child has sent it, once it has arrived
let toRemove = [0]
let enlarged = false
let hasBegun = false // somebody has been here since this page was opened
/** @type {WebSocket} */
let socket

const dialog = findA("front", HTMLDialogElement)
const sure = findA("sure", HTMLDialogElement)
const order = findA("order", HTMLSelectElement)
const list = find("children")

/** @param {string} id @param {boolean} off */
const disable = (id, off) => find(id).toggleAttribute("disabled", off)

/** @param {string} path */
const withToken = (path) => `${path}?${new URLSearchParams({ token })}`

/** @param {string} line */
function say(line) {
  find("playing").textContent = line
}

function connect() {
  const address = new URL(withToken("live"), location.href)
  address.protocol = "ws:"
  socket = new WebSocket(address)
  socket.onopen = () => {
    cards.clear()
    list.replaceChildren()
  }
  socket.onmessage = (event) => take(JSON.parse(event.data))
  socket.onclose = () => {
    say("The class has no connection: look at the terminal in which it runs.")
    setTimeout(connect, 1000)
  }
}

/** @param {Message} message */
function take(message) {
  if (message.type === "playing") say(message.line)
  else if (message.type === "robots") showRobots(message.names)
  else if (message.type === "keeping") showKept(message)
  else if (message.type === "gone") {
    cards.get(message.number)?.item.remove()
    cards.delete(message.number)
    chosen.delete(message.number)
    if (front?.child.number === message.number) dialog.close()
  } else takeChild(message)
  showChosen()
  showCount()
}

/** @param {Child} child */
function takeChild(child) {
  const card = cards.get(child.number) ?? newCard(child)
  card.child = child
  card.show()
  if (front?.child.number !== child.number || !dialog.open) return
  const same = [child.latest, child.good].find((dance) => dance?.count === front?.dance.count)
  describe(child, same ?? front.dance)
}

/** A card whose controls stay the same ones, so that no news takes a tick or a press. @param {Child} child */
function newCard(child) {
  const look = button({ className: "look" }, () => open(card.child, card.child.latest))
  const image = new Image()
  const [name, line, wrong, sent] = ["name", "line", "wrong", "when"].map((className) => element("span", { className }))
  look.append(image, name, line, wrong, sent)
  if (earlier.delete(child.number)) chosen.add(child.number)
  const box = element("input", { type: "checkbox", checked: chosen.has(child.number) })
  const item = element("li", {}, look, element("label", {}, box, "Choose"))
  const show = () => {
    const { latest, good } = card.child
    const shown = good ?? latest
    look.disabled = !shown // there is nothing to look at
    picture(image, shown, "", SMALL)
    name.textContent = card.child.name
    box.setAttribute("aria-label", `Choose ${card.child.name}`)
    line.textContent = shown === null ? "has sent nothing yet" : shown.ok === false ? "" : shown.line
    wrong.textContent = !latest || latest.ok || latest === shown && latest.ok === null ? "" : `${good ? "The latest: " : ""}${latest.line}`
    wrong.className = latest?.ok === false ? "wrong" : "unread"
    showWhen()
  }
  const showWhen = () => {
    const { here, latest } = card.child
    sent.textContent = [here ? "" : "not here", latest && `sent at ${when(1000 * latest.sent)}`, isSilent(card) ? `${Math.floor(silence(card) / 60)} min ago` : ""].filter(Boolean).join(", ")
    sent.classList.toggle("long", isSilent(card))
    item.classList.toggle("away", !here)
    item.classList.toggle("chosen", box.checked)
  }
  /** @type {Card} */
  const card = { child, since: Date.now() / 1000, item, box, show }
  box.addEventListener("change", () => {
    if (box.checked) chosen.add(card.child.number)
    else chosen.delete(card.child.number)
    item.classList.toggle("chosen", box.checked)
    showChosen()
  })
  cards.set(child.number, card)
  list.append(item)
  return card
}

/** Seconds since a child's latest dance. @param {Card} card */
const silence = ({ child, since }) => Date.now() / 1000 - (child.latest?.sent ?? since)

/** @param {Card} card */
const isSilent = (card) => card.child.here && silence(card) >= SILENT

/** Shows how long children have been silent, and puts the cards in order. Nothing moves while a button is pressed. */
function tidy() {
  const silent = [...cards.values()].filter(isSilent)
  for (const card of cards.values()) card.show()
  find("silent").textContent = silent.length ? `Nothing for five minutes: ${silent.map(({ child }) => child.name).join(", ")}` : ""
  const sorted = [...cards.values()].sort(ORDERS[order.value])
  if (list.querySelector(":active") || sorted.every(({ item }, place) => list.children[place] === item)) return
  const focused = /** @type {HTMLElement | null} */ (list.contains(document.activeElement) ? document.activeElement : null)
  list.append(...sorted.map(({ item }) => item))
  focused?.focus()
}

/** @type {Record<string, (one: Card, other: Card) => number>} */
const ORDERS = {
  joined: (one, other) => one.child.number - other.child.number,
  name: (one, other) => one.child.name.localeCompare(other.child.name),
  latest: (one, other) => silence(one) - silence(other),
  silent: (one, other) => silence(other) - silence(one),
}

/** The ticks of a page of before, if it was open in this lesson: it may have been that of a class that has ended since. */
function earlierTicks() {
  const { at = 0, numbers = [] } = stored(TICKS) ?? {}
  return /** @type {number[]} */ (Date.now() - at < SAME_LESSON ? numbers : [])
}

function showChosen() {
  store(TICKS, { at: Date.now(), numbers: [...chosen, ...earlier] })
  disable("play", ![...chosen].some((number) => cards.get(number)?.child.good))
  disable("remove", chosen.size === 0)
  find("choose-all").textContent = cards.size && chosen.size === cards.size ? "Choose none" : "Choose all"
}

function showCount() {
  const here = [...cards.values()].filter(({ child }) => child.here).length
  const earlier = cards.size - here
  hasBegun ||= here > 0
  const lines = [here === 0 ? `Nobody is here${hasBegun ? "" : " yet"}.` : `${here} ${here === 1 ? "child is" : "children are"} here.`]
  if (earlier) lines.push(`${earlier} ${earlier === 1 ? "was" : "were"} here before.`)
  find("count").textContent = lines.join(" ")
  document.body.classList.toggle("empty", enlarged || !hasBegun || cards.size === 0)
  document.body.classList.toggle("nobody", cards.size === 0)
  find("enlarge").hidden = !hasBegun
}

/** @param {{ folder: string, problem: string }} keeping */
function showKept({ folder, problem }) {
  find("kept").textContent = problem || `Everything that children send is kept in ${folder}`
  find("kept").classList.toggle("wrong", problem !== "")
}

/** @param {HTMLImageElement} image @param {Sent | null} dance @param {string} alt @param {string} [style] in SVG */
function picture(image, dance, alt, style = "") {
  const drawn = dance?.picture.replace("</svg>", `${style}</svg>`)
  const source = drawn ? svgAddress(drawn) : ""
  image.hidden = !source
  image.alt = alt
  if (source && image.src !== source) image.src = source
}

/** Brings a child's dance to the front. @param {Child} child @param {Sent | null} dance */
async function open(child, dance) {
  if (!dance) return
  find("front-name").textContent = child.name
  find("front-text").textContent = ""
  frontText = null
  disable("front-save", true)
  describe(child, dance)
  if (!dialog.open) dialog.showModal()
  const answer = await fetch(withToken(`dance/${child.number}/${dance.count}`)).catch(() => null)
  const text = answer?.ok ? await answer.text().catch(() => null) : null
  if (text === null || front?.child.number !== child.number || front.dance.count !== dance.count) return
  frontText = text
  find("front-text").textContent = visible(text)
  disable("front-save", false)
}

/** Shows what is known about the dance in front. @param {Child} child @param {Sent} dance */
function describe(child, dance) {
  front = { child, dance }
  const isLatest = dance.count === child.latest?.count
  const isGood = dance.count === child.good?.count
  find("front-line").textContent = isLatest || isGood ? dance.line : `${child.name} has sent another dance.`
  find("front-which").hidden = isLatest && (!child.good || child.good.count === dance.count)
  find("front-good").hidden = !child.good || child.good.count === child.latest?.count
  find("front-latest").setAttribute("aria-pressed", String(isLatest))
  find("front-good").setAttribute("aria-pressed", String(isGood))
  picture(findA("front-picture", HTMLImageElement), dance, "The paths of the robots")
  for (const id of ["front-play", "front-perform"]) disable(id, !isGood) // nothing plays unseen
}

/** A text with escapes for its hidden characters. @param {string} text */
function visible(text) {
  return text.replace(/\r\n?/g, "\n").replace(HIDDEN, (char) => `\\u{${char.codePointAt(0)?.toString(16)}}`)
}

/** @param {string[]} names of real robots */
function showRobots(names) {
  find("front-real").hidden = names.length === 0
  find("front-robot").replaceChildren(...names.map((name) => new Option(name)))
}

/** @param {object} command */
function send(command) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(command))
}

/** Stops everything, and tries again for a while if a connection breaks meanwhile. */
async function stop() {
  const late = setTimeout(() => say("The stop is not answered: run `improv stop` in a terminal."), NOTICE_DELAY)
  for (let tries = 0; tries < TRIES; tries++) {
    const answer = await fetch(withToken("stop"), { method: "POST", keepalive: true }).catch(() => null)
    clearTimeout(late)
    if (answer) return say(answer.ok ? "Stopped" : "The stop was not obeyed: press Ctrl-C in the terminal.")
    say("The stop did not arrive: press Ctrl-C in the terminal.")
    await new Promise((done) => setTimeout(done, AGAIN))
  }
}

for (const id of ["stop", "front-stop"]) find(id).addEventListener("click", stop) // a dance in front covers the other one
addEventListener("keydown", (event) => event.key === "Escape" && !isOpen() && stop()) // it closes a dance in front
find("play").addEventListener("click", () => send({ type: "play", numbers: [...chosen] }))
find("choose-all").addEventListener("click", () => {
  const all = chosen.size < cards.size
  for (const [number, { box, item }] of cards) {
    box.checked = all
    item.classList.toggle("chosen", all)
    if (all) chosen.add(number)
    else chosen.delete(number)
  }
  showChosen()
})
order.addEventListener("change", tidy)
find("enlarge").addEventListener("click", () => {
  enlarged = !enlarged
  if (enlarged) scrollTo(0, 0) // the whole code can be scanned
  find("enlarge").setAttribute("aria-pressed", String(enlarged))
  showCount()
})
find("open-stage").addEventListener("click", () => window.open(withToken("stage"), "_blank", "noopener"))
find("front-close").addEventListener("click", () => dialog.close())
find("front-latest").addEventListener("click", () => front && open(front.child, front.child.latest))
find("front-good").addEventListener("click", () => front && open(front.child, front.child.good))
find("front-play").addEventListener("click", () => perform(""))
find("front-perform").addEventListener("click", () => perform(findA("front-robot", HTMLSelectElement).value))
find("front-save").addEventListener("click", () => {
  if (front && frontText !== null) download(`${harmless(front.child.name)}.improv`, new Blob([frontText], { type: "text/plain;charset=utf-8" }))
})
find("save-all").addEventListener("click", async () => {
  const answer = await fetch(withToken("dances.zip")).catch(() => null)
  if (answer?.ok) download("dances.zip", await answer.blob())
  else say("The dances can't be saved now: they are in the folder.")
})
find("remove").addEventListener("click", () => askToRemove([...chosen]))
find("front-remove").addEventListener("click", () => front && askToRemove([front.child.number]))
find("sure-keep").addEventListener("click", () => sure.close())
find("sure-remove").addEventListener("click", () => {
  send({ type: "remove", numbers: toRemove })
  sure.close()
})

/** Plays the dance in front. @param {string} robot a real one, or "" */
function perform(robot) {
  send({ type: "perform", number: front?.child.number, count: front?.dance.count, robot })
  dialog.close()
}

/** @param {number[]} numbers of children */
function askToRemove(numbers) {
  toRemove = numbers
  const [first, ...more] = numbers.map((number) => cards.get(number)?.child.name)
  find("sure-title").textContent = more.length ? `Send out ${numbers.length} children?` : `Send out ${first}?`
  sure.showModal()
}

/** @param {string} name */
const harmless = (name) => name.replace(/[^\p{L}\p{N}]+/gu, "_") || "dance"

setInterval(tidy, LOOK)
showCount()
if (token) connect()
else say("This address opens the page once. The terminal shows another one.")
