// Where in the score it is: the latest transport message, moved on by the tempo. No message tells of single beats.

export class Clock {
  transport = { generation: 0, state: "stopped", beat: 0, beats: 0, tempo: 60, speed: 1, wall: 0, performed: 0, muted: [], soloed: [] }

  /** Takes in a transport message. Whether the score was left for another place in it: by a seek, a new beginning. */
  take(message) {
    const expected = this.beat()
    const { generation } = this.transport
    this.transport = { speed: 1, muted: [], soloed: [], ...message }
    return message.generation !== generation || Math.abs(expected - this.beat()) * (60 / message.tempo) > 0.1
  }

  get playing() {
    return this.transport.state === "playing"
  }

  /** The position in beats at this moment. */
  beat() {
    const { beat, beats, wall, tempo } = this.transport
    const gone = this.playing ? ((Date.now() / 1000 - wall) * tempo) / 60 : 0
    return Math.min(Math.max(beat + gone, 0), beats ?? Infinity)
  }

  /** The position in beats at a performance time; undefined for one before the latest change, or if nothing plays. */
  beatAt(time) {
    const { beat, beats, performed, tempo } = this.transport
    if (!this.playing || time < performed) return undefined
    return Math.min(beat + ((time - performed) * tempo) / 60, beats ?? Infinity)
  }

  /** The number of the last beat, counted from 1; a beat that has only begun counts. */
  get lastBeat() {
    return this.transport.beats === null ? Infinity : Math.max(Math.ceil(this.transport.beats), 1)
  }

  /** The number of the present beat, counted from 1. */
  get countedBeat() {
    return Math.min(Math.floor(this.beat() + 1e-6) + 1, this.lastBeat)
  }

  /** Whether a robot stands still while the others play. */
  isSilent(robot) {
    const { muted, soloed } = this.transport
    return soloed.length > 0 ? !soloed.includes(robot) : muted.includes(robot)
  }
}
