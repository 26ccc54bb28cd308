// Where robots start: dragged on the stage or typed, and offered as lines for improv.toml. Nothing is written unasked.

const NEAR = 24 // pixels to a ring
const ARROW = 38 // pixels from its middle to the arrow's tip
const FINEST = 0.001 // metres and degrees, as they are written
const FARTHEST = 1000 // metres along x and y
const FIELDS = { x: ["x", FARTHEST, 0.1], y: ["y", FARTHEST, 0.1], heading: ["heading", 360, 15] }

const find = (id) => document.getElementById(id)

export class Starts {
  #card = find("starts")
  #send
  #changed
  #cast = [] // names and colors
  #poses = new Map() // name -> {x, y, heading}, metres and degrees, as in improv.toml
  #told = new Map() // what the score says
  #chosen = null

  /** `send(message)` offers starts to the server; `changed` is called when there is something to draw. */
  constructor(send, changed) {
    this.#send = send
    this.#changed = changed
    find("starts-copy").addEventListener("click", () => this.#copy())
    find("starts-write").addEventListener("click", () => {
      this.#send({ type: "place", starts: Object.fromEntries(this.#moved()) }) // one edit of the file
    })
  }

  /** Takes the starts of a score. What was dragged stays, unless the score has it now. */
  show(score, cast) {
    const moved = new Map(this.#moved())
    this.#cast = cast
    find("starts-write").hidden = !score.takes_starts
    this.#told = new Map(Object.entries(score.robots).map(([name, { start }]) => [name, degrees(start)]))
    this.#poses = new Map([...this.#told].map(([name, pose]) => [name, { ...(moved.get(name) ?? pose) }]))
    find("starts-list").replaceChildren(...cast.map(({ name, color }) => this.#fields(name, color)))
    this.#offer()
  }

  /** What to draw on the stage: nothing, unless the card is open. */
  get rings() {
    if (!this.#card.open) return []
    return this.#cast.map(({ name, color }) => {
      const { x, y, heading } = this.#poses.get(name)
      return { x, y, heading: (heading * Math.PI) / 180, color, chosen: name === this.#chosen }
    })
  }

  /** Takes hold of a ring or an arrow near a point of the canvas: what moves it, or null. */
  grab(point, camera) {
    if (!this.#card.open) return null
    let best = null
    for (const { name } of this.#cast) {
      const pose = this.#poses.get(name)
      const middle = camera.toScreen(pose)
      const angle = (pose.heading * Math.PI) / 180
      const tip = { x: middle.x + ARROW * Math.cos(angle), y: middle.y - ARROW * Math.sin(angle) }
      for (const [part, place] of [["place", middle], ["heading", tip]]) {
        const distance = Math.hypot(point.x - place.x, point.y - place.y)
        if (distance < NEAR && distance < (best?.distance ?? Infinity)) best = { name, part, distance }
      }
    }
    if (!best) return null
    this.#chosen = best.name
    return (to) => {
      const pose = this.#poses.get(best.name)
      const world = camera.toWorld(to)
      if (best.part === "place") Object.assign(pose, { x: neat(within(world.x, FARTHEST), 0.05), y: neat(within(world.y, FARTHEST), 0.05) })
      else pose.heading = neat((Math.atan2(world.y - pose.y, world.x - pose.x) * 180) / Math.PI, 5)
      this.#showFields(best.name)
      this.#offer()
    }
  }

  #moved() {
    const differs = (one, other) => Object.keys(FIELDS).some((key) => Math.abs(one[key] - other[key]) > 1e-9)
    return [...this.#poses].filter(([name, pose]) => differs(pose, this.#told.get(name)))
  }

  #offer() {
    const lines = this.#moved().map(
      ([name, { x, y, heading }]) => `[robots.${name}]\nstart = { x = ${x}, y = ${y}, heading = ${heading} }\n`,
    )
    find("starts-offer").hidden = !lines.length || find("starts-list").querySelector(":invalid") !== null
    find("starts-lines").textContent = lines.join("\n")
    this.#changed()
  }

  #fields(name, color) {
    const set = document.createElement("fieldset")
    set.dataset.robot = name
    set.style.setProperty("--robot", color)
    const legend = document.createElement("legend")
    legend.textContent = name
    set.append(legend)
    for (const [key, [label, most, step]] of Object.entries(FIELDS)) {
      const field = document.createElement("label")
      const input = document.createElement("input")
      Object.assign(input, { type: "number", required: true, min: -most, max: most, step: "any", value: this.#poses.get(name)[key] })
      input.dataset.key = key
      input.addEventListener("focus", () => {
        this.#chosen = name
        this.#changed()
      })
      input.addEventListener("input", () => {
        if (input.checkValidity()) this.#poses.get(name)[key] = neat(Number(input.value), FINEST)
        this.#offer()
      })
      input.addEventListener("keydown", (event) => {
        if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return
        event.preventDefault()
        const next = Number(input.value) + (event.key === "ArrowUp" ? step : -step)
        input.value = neat(within(next, most), step)
        input.dispatchEvent(new Event("input"))
      })
      field.append(label, input)
      set.append(field)
    }
    return set
  }

  #showFields(name) {
    const set = [...find("starts-list").children].find((each) => each.dataset.robot === name)
    for (const input of set.querySelectorAll("input")) input.value = this.#poses.get(name)[input.dataset.key]
  }

  async #copy() {
    const button = find("starts-copy")
    try {
      await navigator.clipboard.writeText(find("starts-lines").textContent)
      button.textContent = "Copied"
    } catch {
      getSelection().selectAllChildren(find("starts-lines")) // where the browser forbids: ready for Ctrl+C
      button.textContent = "Selected"
    }
    setTimeout(() => (button.textContent = "Copy"), 1500)
  }
}

function degrees([x, y, , heading]) {
  return { x: neat(x, FINEST), y: neat(y, FINEST), heading: neat((heading * 180) / Math.PI, FINEST) }
}

function within(value, most) {
  return Math.min(Math.max(value, -most), most)
}

/** The nearest multiple of a step, written as people would. */
function neat(value, step) {
  return Number((Math.round(value / step) * step).toFixed(4)) || 0
}
