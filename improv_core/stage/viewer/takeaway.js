// Things to take away: the paths as SVG and PNG, and a video of the stage.

import { roundLength } from "./camera.js"
import { along, trace } from "./path.js"

const MARGIN = 0.6 // metres
const PNG_WIDTH = 2400 // pixels of the longer side
const VIDEO = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"]

/** Gives a file to whoever looks at the page. */
export function download(name, blob) {
  const link = document.createElement("a")
  link.href = URL.createObjectURL(blob)
  link.download = name
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000)
}

/**
 * The paths as SVG, a metre a unit: each robot of `cast` with what it has gone, and the exact arcs of what it is told
 * to go. `ground` and `ink` are colors.
 */
export function drawSvg(cast, trails, ground, ink) {
  const shapes = cast.map((robot) => ({ ...robot, ahead: ahead(robot), gone: gone(trails.get(robot.name) ?? []) }))
  const points = shapes.flatMap(({ ahead, gone }) => [...ahead.points, ...gone.points])
  const all = points.length ? points : [{ x: 0, y: 0 }]
  const [left, right] = [Math.min(...all.map(({ x }) => x)) - MARGIN, Math.max(...all.map(({ x }) => x)) + MARGIN]
  const [low, high] = [Math.min(...all.map(({ y }) => y)) - 2 * MARGIN, Math.max(...all.map(({ y }) => y)) + MARGIN]
  const [width, height] = [right - left, high - low]
  const unit = Math.max(width, height) / 100
  const metres = roundLength(unit * 8)
  const names = shapes.filter(({ ahead, gone }) => ahead.points.length || gone.points.length)
  const pixels = PNG_WIDTH / Math.max(width, height)
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${short(width * pixels)}" height="${short(height * pixels)}" viewBox="${[left, -high, width, height].map(short).join(" ")}">
<rect x="${short(left)}" y="${short(-high)}" width="${short(width)}" height="${short(height)}" fill="${ground}"/>
<g fill="none" stroke-linecap="round" stroke-linejoin="round">
${names.map((shape) => drawn(shape, unit, ground)).join("\n")}
</g>
<g font-family="system-ui, sans-serif" font-weight="600" font-size="${short(unit * 2.2)}" text-anchor="middle" fill="${ink}">
${names.map((shape) => label(shape, unit)).join("\n")}
<path d="M${short(left + 2 * unit)} ${short(-low - 3 * unit)}v${short(unit)}h${short(metres)}v${short(-unit)}" fill="none" stroke="${ink}" stroke-width="${short(unit * 0.25)}"/>
<text x="${short(left + 2 * unit + metres / 2)}" y="${short(-low - 3.2 * unit)}">${metres} m</text>
</g>
</svg>
`
}

/** An SVG as a PNG. */
export async function drawPng(svg) {
  const image = new Image()
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}` // the only images the page may load
  await image.decode()
  const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight)
  canvas.getContext("2d").drawImage(image, 0, 0)
  return canvas.convertToBlob({ type: "image/png" })
}

/** Records a canvas from now on; a function that ends it and promises the video. Null where browsers can't. */
export function record(canvas) {
  const type = globalThis.MediaRecorder && VIDEO.find((type) => MediaRecorder.isTypeSupported(type))
  if (!type) return null
  const recorder = new MediaRecorder(canvas.captureStream(30), { mimeType: type, videoBitsPerSecond: 6_000_000 })
  const pieces = []
  recorder.addEventListener("dataavailable", ({ data }) => pieces.push(data))
  const ended = new Promise((done) => recorder.addEventListener("stop", () => done(new Blob(pieces, { type: "video/webm" }))))
  recorder.start(1000)
  return () => {
    if (recorder.state !== "inactive") recorder.stop()
    return ended
  }
}

function drawn({ color, ahead, gone }, unit, ground) {
  const told = `<path d="${ahead.path}" stroke="${color}" stroke-opacity="${gone.path ? 0.4 : 1}" stroke-width="${short(unit * 0.35)}"/>`
  const trail = `<path d="${gone.path}" stroke="${color}" stroke-width="${short(unit * 0.55)}"/>`
  const { x, y } = gone.points[0] ?? ahead.points[0]
  const start = `<circle cx="${short(x)}" cy="${short(-y)}" r="${short(unit * 0.7)}" stroke="${color}" stroke-width="${short(unit * 0.35)}" fill="${ground}"/>`
  return `${ahead.path ? told : ""}${gone.path ? trail : ""}${start}`
}

function label({ name, ahead, gone }, unit) {
  const { x, y } = gone.points[0] ?? ahead.points[0]
  return `<text x="${short(x)}" y="${short(-y + 3.2 * unit)}">${name.replace(/[<>&]/g, "")}</text>`
}

/** The path that a robot is told to go, with exact arcs, and points of it. */
function ahead({ way }) {
  const pen = new SvgPen()
  const points = []
  for (const { pose, velocity, seconds } of way ?? []) {
    if (!pose) continue
    if (!points.length) {
      pen.moveTo(pose.x, pose.y)
      points.push(pose)
    }
    trace(pen, pose, velocity, seconds)
    points.push(...along(pose, velocity, seconds))
  }
  return { path: pen.steps.length > 1 ? pen.steps.join("") : "", points }
}

function gone(points) {
  const path = points.map(({ x, y, first }, i) => `${i && !first ? "L" : "M"}${short(x)} ${short(-y)}`).join("")
  return { path: points.length > 1 ? path : "", points }
}

/** Takes what a canvas's pen takes; y is up. */
class SvgPen {
  steps = []

  moveTo(x, y) {
    this.steps.push(`M${short(x)} ${short(-y)}`)
  }

  lineTo(x, y) {
    this.steps.push(`L${short(x)} ${short(-y)}`)
  }

  arc(x, y, radius, from, to) {
    const parts = Math.max(Math.ceil(Math.abs(to - from) / 3), 1) // SVG has no arc of a whole turn
    for (let i = 1; i <= parts; i++) {
      const angle = from + ((to - from) * i) / parts
      const [endX, endY] = [x + radius * Math.cos(angle), y + radius * Math.sin(angle)]
      this.steps.push(`A${short(radius)} ${short(radius)} 0 0 ${to > from ? 0 : 1} ${short(endX)} ${short(-endY)}`)
    }
  }
}

function short(number) {
  return String(Number(number.toFixed(4)))
}
