// @ts-check
// The handle of the movement at the cursor: dragged on the floor, it changes the measure in the text.

import { findA } from "../base/elements.js"
import { colors, mix } from "../base/colors.js"
import { redraw } from "../base/frames.js"
import { announce } from "../base/notices.js"
import { send } from "../net/send.js"
import { robotList } from "../score/robot-list.js"

/** @import { Camera, Point } from "./camera.js" */
/** @import { Hold } from "./gestures.js" */
/** @import { Change } from "../score/changes.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {{ number: number | null, offset: number }} Cursor the number of the text, once the server has it, and an offset in code points */

const SIZE = 9 // pixels: the handle's radius,
const DOT_SIZE = 3 // and that of the places where the same words end, which can't be dragged
const GRAB_RADIUS = 24 // pixels
const STEPS = /** @type {Record<string, number>} */ ({ ArrowUp: 1, ArrowDown: -1 })

export class Handle {
  #control = findA("text", HTMLTextAreaElement)
  #cursor
  #change
  /** @type {Messages["handle"] | null} */
  shown = null
  #asked = "" // the latest question
  /** @type {"draw" | "perform" | null} */
  #gesture = null // in progress: then the handle is in the way
  #isDrawn = false
  #held = false
  #changed = false // by a hand or a key, so that the new words are read out

  /** @param {() => Cursor} cursor @param {(change: Change) => void} change */
  constructor(cursor, change) {
    this.#cursor = cursor
    this.#change = change
    document.addEventListener("selectionchange", () => this.look())
    this.#control.addEventListener("keydown", (event) => this.#press(event))
  }

  /** Asks for the handle at the cursor, if it may be another one. */
  look() {
    const { number, offset } = this.#cursor()
    if (this.#isDrawn && offset !== this.shown?.offset) redraw() // it is of another word
    const draws = this.#gesture === "draw"
    const asked = JSON.stringify([number, offset, draws])
    if (!(this.#isWanted || draws) || number === null || asked === this.#asked) return
    this.#asked = asked
    send({ type: "handle", number, offset, draws })
  }

  /** What somebody does by hand. Who draws needs to know where robots come to the cursor. */
  set gesture(/** @type {"draw" | "perform" | null} */ gesture) {
    if (gesture !== this.#gesture) this.#asked = "" // the answer was for somebody who has drawn another robot
    this.#gesture = gesture
    this.look()
  }

  /** Returns whether a message is about the cursor as it is. @param {Messages["handle"]} message */
  take(message) {
    const { number, offset } = this.#cursor()
    if (message.number !== number || message.offset !== offset) return false
    if (this.#changed && message.text && message.text !== this.shown?.text) announce(message.text)
    this.#changed &&= this.#held
    if (drawing(message) !== drawing(this.shown)) redraw()
    this.shown = message
    return true
  }

  /**
   * Grabs the handle near a point of the canvas. Returns a hold of it, or null.
   * @param {Point} point
   * @param {Camera} camera
   * @param {() => boolean} freely
   * @returns {Hold | null}
   */
  grab(point, camera, freely) {
    const place = this.#place(camera)
    if (!place || Math.hypot(point.x - place.x, point.y - place.y) > GRAB_RADIUS) return null
    this.#held = true
    const { offset } = this.#cursor()
    const move = (/** @type {Point} */ to) => {
      const { x, y } = camera.toWorld(to)
      this.#changed = true
      this.#change({ type: "bend", offset, place: [x, y], freely: freely() })
    }
    return { move, release: () => (this.#held = false) }
  }

  /** @param {Pen} pen @param {Camera} camera */
  draw(pen, camera) {
    this.#isDrawn = this.#place(camera) !== null
    if (!this.#isDrawn || !this.shown?.place) return
    const color = robotList.colorOf(this.shown.robot)
    const faint = mix(colors().ground, color, 0.5)
    for (const [x, y] of this.shown.others) {
      const place = camera.toScreen({ x, y })
      pen.fillStyle = faint
      pen.beginPath()
      pen.arc(place.x, place.y, DOT_SIZE, 0, 2 * Math.PI)
      pen.fill()
    }
    drawEnd(pen, camera, this.shown.place, color, this.#held ? 5 : 3)
  }

  /** The handle's place on the canvas, if it is shown. @param {Camera} camera */
  #place(camera) {
    const [x, y] = this.shown?.place ?? []
    const isHere = this.#held || this.shown?.offset === this.#cursor().offset
    return this.#isWanted && isHere && x !== undefined ? camera.toScreen({ x, y }) : null
  }

  /** True while somebody writes, or holds the handle of what is written. */
  get #isWanted() {
    if (this.#gesture) return false
    return this.#held || document.activeElement === this.#control || document.activeElement?.id === "stage"
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    const steps = STEPS[event.key]
    if (!steps || !event.altKey || event.ctrlKey || event.metaKey || !this.shown?.place) return
    event.preventDefault()
    this.#changed = true
    this.#change({ type: "lengthen", offset: this.#cursor().offset, steps, freely: event.shiftKey })
  }
}

/** All that is drawn of a handle. @param {Messages["handle"] | null} handle */
function drawing(handle) {
  return handle?.place ? JSON.stringify([handle.robot, handle.place, handle.others]) : ""
}

/**
 * Draws a circle, and a line to it from the robot.
 * @param {Pen} pen
 * @param {Camera} camera
 * @param {number[]} ends
 * @param {string} color
 * @param {number} width
 */
function drawEnd(pen, camera, [x, y, robotX, robotY], color, width) {
  const [place, robot] = [camera.toScreen({ x, y }), camera.toScreen({ x: robotX, y: robotY })]
  for (const [ink, wide] of /** @type {[string, number][]} */ ([[colors().ground, width + 4], [color, width]])) {
    pen.strokeStyle = ink
    pen.lineWidth = wide
    pen.beginPath()
    pen.moveTo(robot.x, robot.y)
    pen.lineTo(place.x, place.y)
    pen.stroke()
    pen.beginPath()
    pen.arc(place.x, place.y, SIZE, 0, 2 * Math.PI)
    pen.fillStyle = colors().ground
    pen.fill()
    pen.stroke()
  }
}
