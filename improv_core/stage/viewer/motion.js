// What the page knows of the robots: their latest poses in performance time, and the ways they have gone.

const DELAY = 0.05 // seconds the page shows behind the newest poses, to have a pose on either side of its own time
const CLOCK_ERROR = 0.01 // seconds between the clock of the messages and that of the page's frames, at most
const FRAMES_KEPT = 30
const TRAIL_POINTS = 4000
const TRAIL_STEP = 0.01 // metres between two points of a trail

export class Motion {
  #frames = []
  #offset = -Infinity // performance time minus the page's clock
  #shown = -Infinity // the latest performance time presented: a page that was held up never goes back
  trails = new Map() // name -> [{at, x, y}]

  clear() {
    this.#frames = []
    this.#offset = -Infinity
    this.#shown = -Infinity
    this.trails.clear()
  }

  /** Forgets the ways gone more than `age` seconds before `now`: those of an earlier program. */
  forgetTrails(now, age) {
    const since = now + this.#offset - age - CLOCK_ERROR
    for (const [name, trail] of this.trails) {
      const kept = trail.filter(({ at }) => at >= since)
      if (kept.length) this.trails.set(name, kept)
      else this.trails.delete(name)
    }
  }

  /** Forgets robots that are not in `names`. */
  keep(names) {
    for (const name of this.trails.keys()) if (!names.has(name)) this.trails.delete(name)
  }

  /** Takes in poses that arrived at `now`, in seconds of the page's clock. */
  take({ at, poses }, now) {
    if (at < this.#frames.at(-1)?.at) this.clear() // a new performance
    const offset = at - now
    // Messages are late, never early, so the largest offset is the truest; it gives way slowly, as clocks drift, and
    // at once after a pause of the performance.
    this.#offset = this.#offset - offset > 0.25 ? offset : Math.max(this.#offset - 0.0002, offset)
    if (at === this.#frames.at(-1)?.at) this.#frames.pop() // the cast has changed
    this.#frames.push({ at, poses })
    if (this.#frames.length > FRAMES_KEPT) this.#frames.shift()
    for (const [name, [x, y]] of Object.entries(poses)) this.#draw(name, at, x, y)
  }

  #draw(name, at, x, y) {
    const trail = this.trails.get(name)
    if (!trail) {
      this.trails.set(name, [{ at, x, y }])
      return
    }
    const last = trail.at(-1)
    if (Math.hypot(x - last.x, y - last.y) < TRAIL_STEP) return
    trail.push({ at, x, y })
    if (trail.length > TRAIL_POINTS) trail.shift()
  }

  /** Performance time and poses to show at `now`, and whether later ones will differ without a new message. */
  present(now) {
    const frames = this.#frames
    if (!frames.length) return { at: 0, robots: {}, moving: false }
    const newest = frames.at(-1)
    const at = Math.min(Math.max(now + this.#offset - DELAY, this.#shown), newest.at)
    this.#shown = at
    const next = frames.findIndex((frame) => frame.at >= at)
    const after = frames[next]
    const before = frames[Math.max(next - 1, 0)]
    const part = after.at > before.at ? Math.max((at - before.at) / (after.at - before.at), 0) : 1
    const robots = {}
    for (const [name, to] of Object.entries(after.poses)) {
      const from = before.poses[name] ?? to
      const [x, y, z, heading] = to.map((value, axis) => from[axis] + (value - from[axis]) * part)
      robots[name] = { x, y, z, heading }
    }
    return { at, robots, moving: at < newest.at }
  }
}
