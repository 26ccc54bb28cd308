// @ts-check
// Requests of a page, and the least and most of their numbers. Written by `python -m tests.page_requests`
// from the types in commands.py, editing.py, and messages.py.

/** @typedef {{ x: number, y: number, heading: number }} StartPose in meters and degrees */
/**
 * @typedef {{ type: "stop" }
 *   | { type: "pause" }
 *   | { type: "resume", anyway?: boolean, beat?: number }
 *   | { type: "seek", beat: number }
 *   | { type: "speed", factor: number }
 *   | { type: "silence", muted: string[], soloed: string[] }
 *   | { type: "held" }
 *   | { type: "released" }
 *   | { type: "cue" }
 *   | { type: "key", key: string, held: boolean }
 *   | { type: "force", robot: string, sense: string, value: boolean | null }
 *   | { type: "restart" }
 *   | { type: "window", generation: number, from: number, to: number }
 *   | { type: "analyze", number: number, text: string }
 *   | { type: "complete", number: number, offset: number }
 *   | { type: "explain", number: number, offset: number }
 *   | { type: "handle", number: number, offset: number, draws: boolean }
 *   | { type: "preview", number: number, known?: number }
 *   | { type: "write", number: number, text: string, revision: string }
 *   | { type: "change", number: number, change: { type: "place", start_poses: Record<string, StartPose> } | { type: "arrange", shape: "line" | "circle" | "grid", distance: number, facing: "in" | "out" } | { type: "tune", key: "beat" | "first_beat", value: number } | { type: "bend", offset: number, place: number[], freely: boolean } | { type: "lengthen", offset: number, steps: number, freely: boolean } | { type: "draw", robot: string, offset?: number, points: number[][], parts: number, begin?: number } | { type: "perform", robot: string, keys: number[][], end: number, parts: number, begin?: number } }} Request
 */

export const LIMITS = {
  speed: { factor: [0.1, 4] },
  arrange: { distance: [0.001, 1000] },
  tune: { value: [-3600, 3600] },
  lengthen: { steps: [-1000, 1000] },
  draw: { parts: [0, 12] },
  perform: { parts: [0, 12] },
}
