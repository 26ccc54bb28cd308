// @ts-check
// Files to save: the paths as SVG and PNG, and a video of the stage.

import { download, element, find, svgAddress } from "../base/elements.js"
import { announce } from "../base/notices.js"
import { penOn } from "../base/pen.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"

const PNG_WIDTH = 2400 // pixels of the longer side
const VIDEO = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"]

/** An SVG as a PNG. @param {string} svg */
async function drawPng(svg) {
  const image = element("img", { src: svgAddress(svg) })
  await image.decode()
  const scale = PNG_WIDTH / Math.max(image.naturalWidth, image.naturalHeight)
  const canvas = new OffscreenCanvas(Math.round(image.naturalWidth * scale), Math.round(image.naturalHeight * scale))
  const pen = penOn(canvas)
  pen.drawImage(image, 0, 0, canvas.width, canvas.height)
  return canvas.convertToBlob({ type: "image/png" })
}

/** Lets people save the paths, and a video of a canvas. @param {HTMLCanvasElement} canvas */
export function offerFiles(canvas) {
  find("save-svg").addEventListener("click", () => savePaths(".svg", (svg) => new Blob([svg], { type: "image/svg+xml" })))
  find("save-png").addEventListener("click", () => savePaths(".png", drawPng))
  find("record").addEventListener("click", () => {
    if (recording) finishRecording()
    else if (isWaiting) showRecording("Record a video")
    else showRecording("Recording begins with the dance", true)
    recordDance(canvas)
  })
}

/** @param {string} ending @param {(svg: string) => Blob | Promise<Blob>} make */
async function savePaths(ending, make) {
  const svg = await program.getPicture()
  if (svg) download(`${program.stem}${ending}`, await make(svg))
  else announce("No picture yet. Save a program first.")
}

/** @type {(() => Promise<Blob>) | null} */
let recording = null // ends it
let isWaiting = false // for the dance, to record it

/** Begins the video that somebody has asked for once the dance plays, and saves it once that ends. @param {HTMLCanvasElement} canvas */
export function recordDance(canvas) {
  if (recording && ["ended", "stopped"].includes(clock.transport.state)) finishRecording()
  if (!isWaiting || !clock.playing) return
  recording = record(canvas)
  showRecording(recording ? "Stop and save the video" : "This browser can't record video")
  if (!recording) announce("This browser can't record video")
}

/** Saves the video that is being recorded. */
async function finishRecording() {
  const end = recording
  recording = null
  showRecording("Record a video")
  if (end) download(`${program.stem}.webm`, await end())
}

/** @param {string} text @param {boolean} [waits] */
function showRecording(text, waits = false) {
  isWaiting = waits
  find("record").textContent = text
  find("record").setAttribute("aria-pressed", String(waits || recording !== null))
  document.body.dataset.recording = String(recording !== null)
}

/**
 * Records a canvas. Returns a function that ends the recording and promises the video; null if the browser can't.
 * @param {HTMLCanvasElement} canvas
 */
function record(canvas) {
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
