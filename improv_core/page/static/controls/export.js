// @ts-check
// Files to save: the paths as SVG and PNG, and a video of the stage.

import { element, svgAddress } from "../base/elements.js"
import { penOn } from "../base/pen.js"
import { withToken } from "../net/token.js"

const PNG_WIDTH = 2400 // pixels of the longer side
const VIDEO = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"]

/**
 * Saves a file.
 * @param {string} name
 * @param {Blob} blob
 */
export function download(name, blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name })
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000)
}

/** The paths as SVG, drawn by the server; null if there are none, or no server. */
export async function fetchPaths() {
  try {
    const answer = await fetch(withToken("path.svg"))
    return answer.ok ? await answer.text() : null
  } catch {
    return null
  }
}

/**
 * An SVG as a PNG.
 * @param {string} svg
 */
export async function drawPng(svg) {
  const image = element("img", { src: svgAddress(svg) })
  await image.decode()
  const scale = PNG_WIDTH / Math.max(image.naturalWidth, image.naturalHeight)
  const canvas = new OffscreenCanvas(Math.round(image.naturalWidth * scale), Math.round(image.naturalHeight * scale))
  const pen = penOn(canvas)
  pen.drawImage(image, 0, 0, canvas.width, canvas.height)
  return canvas.convertToBlob({ type: "image/png" })
}

/**
 * Records a canvas. Returns a function that ends the recording and promises the video; null if the browser can't.
 * @param {HTMLCanvasElement} canvas
 */
export function record(canvas) {
  const type = globalThis.MediaRecorder && VIDEO.find((type) => MediaRecorder.isTypeSupported(type))
  if (!type) return null
  const recorder = new MediaRecorder(canvas.captureStream(30), { mimeType: type, videoBitsPerSecond: 6_000_000 })
  /** @type {Blob[]} */
  const pieces = []
  recorder.addEventListener("dataavailable", ({ data }) => pieces.push(data))
  /** @type {Promise<Blob>} */
  const ended = new Promise((done) => recorder.addEventListener("stop", () => done(new Blob(pieces, { type: "video/webm" }))))
  recorder.start(1000)
  return () => {
    if (recorder.state !== "inactive") recorder.stop()
    return ended
  }
}
