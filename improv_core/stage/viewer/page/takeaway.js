// Things to take away: the paths as SVG and PNG, and a video of the stage.

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

/** The paths as SVG, which the server draws; null where there are none, or no server. */
export async function fetchPicture() {
  try {
    const answer = await fetch(`path.svg${location.search}`)
    return answer.ok ? await answer.text() : null
  } catch {
    return null
  }
}

/** An SVG as a PNG, on white. */
export async function drawPng(svg) {
  const image = new Image()
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}` // the only images the page may load
  await image.decode()
  const scale = PNG_WIDTH / Math.max(image.naturalWidth, image.naturalHeight)
  const canvas = new OffscreenCanvas(Math.round(image.naturalWidth * scale), Math.round(image.naturalHeight * scale))
  const pen = canvas.getContext("2d")
  pen.fillStyle = "#ffffff"
  pen.fillRect(0, 0, canvas.width, canvas.height)
  pen.drawImage(image, 0, 0, canvas.width, canvas.height)
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
