// @ts-check
// The teacher's page: the dances of a class, small; one in front; several together; and a stop for everything.

/** @typedef {{ type: "child", number: number, name: string, count: number, ok: boolean, line: string, picture: string }} Child */
/** @typedef {Child | { type: "gone", number: number } | { type: "robots", names: string[] } | { type: "playing", line: string }} Message */

const KEY = "improv.class.token"
const AGAIN = 100 // milliseconds until a stop that did not arrive is sent again
const TRIES = 50
const HIDDEN = /[^\P{C}\n\t]|[^\P{Z} ]/gu // what shows nothing, or turns text
const given = document.querySelector("#token")?.getAttribute("content") ?? ""
if (given) sessionStorage.setItem(KEY, given)
const token = given || (sessionStorage.getItem(KEY) ?? "")
if (location.search) history.replaceState(null, "", location.pathname)

/** @type {Map<number, Child>} */
const children = new Map()
/** @type {Set<number>} */
const chosen = new Set()
/** @type {Child | undefined} */
let front // as it was looked at: another dance that the child sends meanwhile doesn't take its place
/** @type {string | null} */
let frontText = null // as the child has sent it, once it has arrived
/** @type {WebSocket} */
let socket

const dialog = /** @type {HTMLDialogElement} */ (find("front"))
const list = find("children")

/** @param {string} id */
function find(id) {
  const element = document.getElementById(id)
  if (!element) throw new Error(`the page has no ${id}`)
  return element
}

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
    children.clear()
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
  else if (message.type === "gone") {
    children.delete(message.number)
    chosen.delete(message.number)
    document.getElementById(`child-${message.number}`)?.remove()
    if (front?.number === message.number) dialog.close()
  } else {
    children.set(message.number, message)
    draw(message)
    if (front?.number === message.number && dialog.open) {
      if (front.count === message.count) describe(message)
      else find("front-line").textContent = `${message.name} has sent another dance. Close this one to look at it.`
    }
  }
  showChosen()
  const count = children.size
  find("count").textContent = count === 0 ? "Nobody is here yet." : `${count} ${count === 1 ? "child is" : "children are"} here.`
}

/** @param {Child} child */
function draw(child) {
  const id = `child-${child.number}`
  const item = document.getElementById(id) ?? list.appendChild(Object.assign(document.createElement("li"), { id }))
  const hadFocus = item.contains(document.activeElement) ? document.activeElement?.tagName : ""
  const look = document.createElement("button")
  look.type = "button"
  look.className = child.ok || child.count === 0 ? "look" : "look wrong"
  if (child.picture) look.append(picture(new Image(), child, ""))
  look.append(line("name", child.name), line("line", child.line))
  look.addEventListener("click", () => show(child))
  const label = document.createElement("label")
  const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: chosen.has(child.number) })
  box.addEventListener("change", () => {
    if (box.checked) chosen.add(child.number)
    else chosen.delete(child.number)
    item.classList.toggle("chosen", box.checked)
    showChosen()
  })
  label.append(box, "Choose")
  box.setAttribute("aria-label", `Choose ${child.name}`)
  item.replaceChildren(look, label)
  item.classList.toggle("chosen", chosen.has(child.number))
  if (hadFocus === "BUTTON") look.focus()
  else if (hadFocus) box.focus()
}

/** The chosen children whose dances can be played. */
const playable = () => [...chosen].filter((number) => children.get(number)?.ok)

function showChosen() {
  disable("play", playable().length === 0)
  disable("remove", chosen.size === 0)
}

/** @param {string} kind @param {string} text */
function line(kind, text) {
  return Object.assign(document.createElement("span"), { className: kind, textContent: text })
}

/** @param {HTMLImageElement} image @param {Child} child @param {string} alt */
function picture(image, child, alt) {
  image.hidden = !child.picture
  image.alt = alt
  if (child.picture) image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(child.picture)}`
  return image
}

/** Brings a child's dance to the front. @param {Child} child */
async function show(child) {
  find("front-name").textContent = child.name
  find("front-text").textContent = ""
  frontText = null
  disable("front-save", true)
  describe(child)
  if (!dialog.open) dialog.showModal()
  const answer = await fetch(withToken(`dance/${child.number}/${child.count}`)).catch(() => null)
  const text = answer?.ok ? await answer.text().catch(() => null) : null
  if (text === null || front?.number !== child.number || front.count !== child.count) return
  frontText = text
  find("front-text").textContent = visible(text)
  disable("front-save", false)
}

/** Shows what is known about the dance in front. @param {Child} child */
function describe(child) {
  front = child
  find("front-line").textContent = child.line
  picture(/** @type {HTMLImageElement} */ (find("front-picture")), child, "The paths of the robots")
  for (const id of ["front-play", "front-perform"]) disable(id, !child.ok)
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
  for (let tries = 0; tries < TRIES; tries++) {
    const answer = await fetch(withToken("stop"), { method: "POST", keepalive: true }).catch(() => null)
    if (answer?.ok) return
    say(answer ? "The stop was not obeyed: press Ctrl-C in the terminal." : "The stop did not arrive: press Ctrl-C in the terminal.")
    if (answer) return
    await new Promise((done) => setTimeout(done, AGAIN))
  }
}

for (const id of ["stop", "front-stop"]) find(id).addEventListener("click", stop) // a dance in front covers the other one
addEventListener("keydown", (event) => event.key === "Escape" && stop())
find("play").addEventListener("click", () => send({ type: "play", numbers: playable() }))
find("remove").addEventListener("click", () => send({ type: "remove", numbers: [...chosen] }))
find("open-stage").addEventListener("click", () => open(withToken("stage"), "_blank", "noopener"))
find("front-close").addEventListener("click", () => dialog.close())
find("front-play").addEventListener("click", () => {
  send({ type: "play", numbers: [front?.number] })
  dialog.close()
})
find("front-perform").addEventListener("click", () => {
  const robot = /** @type {HTMLSelectElement} */ (find("front-robot")).value
  send({ type: "perform", number: front?.number, count: front?.count, robot })
  dialog.close()
})
find("front-remove").addEventListener("click", () => send({ type: "remove", numbers: [front?.number] }))
find("front-save").addEventListener("click", () => {
  if (!front || frontText === null) return
  const link = document.createElement("a")
  link.href = URL.createObjectURL(new Blob([frontText], { type: "text/plain;charset=utf-8" }))
  link.download = `${front.name.replace(/[^\p{L}\p{N}]+/gu, "_") || "dance"}.improv`
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000)
})
connect()
