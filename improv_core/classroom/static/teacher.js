// @ts-check
// The teacher's page: the dances of a class, small; one in front; several together; and a stop for everything.

/** @typedef {{ type: "child", number: number, name: string, count: number, ok: boolean, line: string, picture: string, text: string }} Child */
/** @typedef {Child | { type: "gone", number: number } | { type: "robots", names: string[] } | { type: "playing", line: string }} Message */

const KEY = "improv.class.token"
const AGAIN = 100 // milliseconds until a stop that did not arrive is sent again
const TRIES = 50
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
/** @type {WebSocket} */
let socket

const dialog = /** @type {HTMLDialogElement} */ (find("front"))
const list = find("children")
const play = /** @type {HTMLButtonElement} */ (find("play"))

/** @param {string} id */
function find(id) {
  const element = document.getElementById(id)
  if (!element) throw new Error(`the page has no ${id}`)
  return element
}

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
    if (!message.ok) chosen.delete(message.number)
    draw(message)
    if (front?.number === message.number && dialog.open) {
      if (front.count === message.count) show(message)
      else find("front-line").textContent = `${message.name} has sent another dance. Close this one to look at it.`
    }
  }
  play.disabled = chosen.size === 0
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
  const box = Object.assign(document.createElement("input"), { type: "checkbox", disabled: !child.ok, checked: chosen.has(child.number) })
  box.addEventListener("change", () => {
    if (box.checked) chosen.add(child.number)
    else chosen.delete(child.number)
    item.classList.toggle("chosen", box.checked)
    play.disabled = chosen.size === 0
  })
  label.append(box, "Play")
  box.setAttribute("aria-label", `Play ${child.name}`)
  item.replaceChildren(look, label)
  item.classList.toggle("chosen", chosen.has(child.number))
  if (hadFocus === "BUTTON") look.focus()
  else if (hadFocus) box.focus()
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
function show(child) {
  front = child
  find("front-name").textContent = child.name
  find("front-line").textContent = child.line
  find("front-text").textContent = child.text
  picture(/** @type {HTMLImageElement} */ (find("front-picture")), child, "The paths of the robots")
  const own = /** @type {HTMLButtonElement} */ (find("front-play"))
  own.disabled = !child.ok
  find("front-perform").toggleAttribute("disabled", !child.ok)
  if (!dialog.open) dialog.showModal()
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
play.addEventListener("click", () => send({ type: "play", numbers: [...chosen] }))
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
find("front-remove").addEventListener("click", () => send({ type: "remove", number: front?.number }))
find("front-save").addEventListener("click", () => {
  const child = front
  if (!child) return
  const link = document.createElement("a")
  link.href = URL.createObjectURL(new Blob([child.text], { type: "text/plain;charset=utf-8" }))
  link.download = `${child.name.replace(/[^\p{L}\p{N}]+/gu, "_") || "dance"}.improv`
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000)
})
connect()
