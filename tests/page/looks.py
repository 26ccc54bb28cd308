"""Colors of the stage: functions of JavaScript that read its pixels."""

from __future__ import annotations

# Number of pixels of the stage with about this color: [red, green, blue].
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
