"""What the stage looks like: functions of JavaScript that read its pixels."""

from __future__ import annotations

# How many pixels of the stage are of a color, give or take: [red, green, blue].
COUNT = """([red, green, blue]) => {
  const stage = document.getElementById("stage")
  const copy = new OffscreenCanvas(stage.width, stage.height)
  const pen = copy.getContext("2d")
  pen.drawImage(stage, 0, 0)
  const { data } = pen.getImageData(0, 0, copy.width, copy.height)
  let count = 0
  for (let i = 0; i < data.length; i += 4) {
    if (Math.abs(data[i] - red) + Math.abs(data[i + 1] - green) + Math.abs(data[i + 2] - blue) < 12) count++
  }
  return count
}"""
# The color of the stage at a point of the world.
PIXEL = """(x, y) => {
  const place = improv.toScreen(x, y)
  const stage = document.getElementById("stage")
  const copy = new OffscreenCanvas(stage.width, stage.height)
  const pen = copy.getContext("2d")
  pen.drawImage(stage, 0, 0)
  return pen.getImageData(Math.round(place.x), Math.round(place.y), 1, 1).data.slice(0, 3).join()
}"""
# Counts in `slanted` the lines that are drawn neither upright nor level once `watched` is set, on sheets and the stage.
SLANTED = """
window.slanted = 0
for (const { prototype } of [CanvasRenderingContext2D, OffscreenCanvasRenderingContext2D]) {
  const { moveTo, lineTo } = prototype
  let last = null
  prototype.moveTo = function (x, y) {
    last = { x, y }
    moveTo.call(this, x, y)
  }
  prototype.lineTo = function (x, y) {
    const slants = last && Math.abs(x - last.x) > 4 && Math.abs(y - last.y) > 4
    if (slants && window.watched && this.canvas.id !== "rows") window.slanted++
    last = { x, y }
    lineTo.call(this, x, y)
  }
}"""
