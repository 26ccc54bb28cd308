// The messages that pages get, by type, and that they send. `python -m tests.page_requests` writes them
// from the types in `improv_core/protocol/page_messages.py`.
interface Messages {
  robots: { type: "robots", robots: Record<string, { radius: number, joints: string[] }> }
  time: { type: "time", wall: number }
  poses: { type: "poses", at: number, placed: number, poses: number[][], joints: Record<string, number[]> }
  trails: { type: "trails", placed: number, robots: Record<string, { from: number, places: number[][] }> }
  measured: { type: "measured", robots: Record<string, { from: number, places: number[][] }> }
  transport: { start?: Record<string, { x: number, y: number, z: number, heading: number }>, poses?: Record<string, { x: number, y: number, z: number, heading: number }>, begins?: Record<string, number>, scene?: { index: number, begins: number }, pace?: number, behind?: number, type: "transport", generation: number, restarted: number, state: "waiting" | "playing" | "paused" | "ended" | "stopped", backend: string, tempo: number, speed: number, beats: number | null, beat: number, performed: number, muted: string[], soloed: string[], monotonic: number, wall: number, waits_for?: string[], too_near?: string[], resumes?: { scene: number, beat: number }, startable_by?: ("osc" | "ros")[], bar?: number, deserted?: boolean }
  stopped: { start?: Record<string, { x: number, y: number, z: number, heading: number }>, poses?: Record<string, { x: number, y: number, z: number, heading: number }>, type: "stopped", message?: string }
  program: { type: "program", name: string, folder: string, problems: { file: string, line: number, column: number, word: string, message: string }[], count: number, names?: Record<string, string> }
  score: { type: "score", generation: number, tempo: number, scene: number, scenes: number[], scene_names: string[], bar: number | null, beats: number | null, world: any | null, text: string, offsets: Record<string, number>, words: Record<string, number[]>, robots: Record<string, { profile: string, radius: number, motions: string[], body: ({ name: string, joints: ({ name: string, axis: string, sign: number, slides: boolean, min: number | null, max: number | null, start: number })[], moves: boolean })[], dynamics: string, speeds: number[], start_pose: number[], begins: number, ends: number | null, senses: Record<string, any>, near: number }>, skeletons: Record<string, ({ joint: string, carrier: number, place: number[], turn: number[], axis: number[], way: "turns" | "slides" | "stays", rest: number, follows: string | null, ratio: number, shift: number })[]>, takes_start_poses: boolean, deadman: { button: number } | null, music: { file: string, first_beat: number, volume: number } | null }
  bumps: { type: "bumps", past: boolean, bumps: { at: number, x: number, y: number, robots: string[], thing: string }[] }
  window: { type: "window", generation: number, from: number, to: number, robots: Record<string, { pose: number[] | null, moments: any[][], body: Record<string, any[][]>, until: number }> }
  meetings: { type: "meetings", generation: number, from: number, to: number, all: boolean, assumes: boolean, meetings: { robots: string[], beat: number, distance: number, more: number, poses: number[][] }[], hits: { robot: string, thing: string, beat: number, pose: number[] }[] }
  misplaced: { type: "misplaced", generation: number, waits: boolean, robots: Record<string, { place: { x: number, y: number, z: number, heading: number }, pose: { x: number, y: number, z: number, heading: number } | null, line: string }> }
  armed: { type: "armed", generation: number, armed: boolean, begins: number | null, count?: { beats: number, period: number } }
  sensed: { beat: number, performed: number, wall: number, generation: number, robot: string, type: "sensed", sense: string, value: boolean | null }
  decided: { beat: number, performed: number, wall: number, generation: number, robot: string, type: "decided", sources: number[][], held: boolean }
  fault: { beat: number, performed: number, wall: number, generation: number, robot: string, type: "fault", fault: "off_path" | "silent" | "jumped" | "stuck" | "joints" | "gone" | "late", over: boolean, response: "tell" | "stand" | "stop", worst: { distance?: number, turn?: number, seconds?: number }, message: string, line: string }
  vitals: { type: "vitals", generation: number, robots: Record<string, { odom: boolean, posed: number | null, battery: number | null, instead: "" | "stands" | "drives back" }> }
  why_still: { type: "why_still", line: string, resumes?: { scene: number, beat: number } }
  link: { type: "link", host: string, offset: number, error: number, round_trip: number, lag: number }
  joints: { beat: number, performed: number, wall: number, generation: number, robot: string, type: "joints", positions: Record<string, number> }
  source: { type: "source", path: string, text: string, revision: string, toml: string }
  draft: { type: "draft", text: string, paths: { type: "preview", number: number, robots: Record<string, { start: number[], strokes: number[][], certain: number, look: { profile: string, radius: number, motions: string[], body: ({ name: string, joints: ({ name: string, axis: string, sign: number, slides: boolean, min: number | null, max: number | null, start: number })[], moves: boolean })[] } } | null>, problem: string, waits_for: string[] } }
  analyze: { problems: { start: number, end: number, file: string, line: number, severity: string, message: string, fixes: { title: string, kind: string, edits: { start: number, end: number, text: string }[] }[] }[], count: number, type: "analyze", number: number, colors: { first: number, last: number, new: number[] }, starts: Record<string, { x: number, y: number, heading: number }> }
  check: { problems: { start: number, end: number, file: string, line: number, severity: string, message: string, fixes: { title: string, kind: string, edits: { start: number, end: number, text: string }[] }[] }[], count: number, type: "check", number: number }
  complete: { type: "complete", number: number, start: number, end: number, words: { word: string, about: string }[] }
  explain: { type: "explain", number: number, start: number, end: number, text: string, picture: string }
  handle: { type: "handle", number: number, offset: number, robot: string, text: string, place: number[] | null, others: number[][], pens: Record<string, number[]> }
  preview: { type: "preview", number: number, robots: Record<string, { start: number[], strokes: number[][], certain: number, look: { profile: string, radius: number, motions: string[], body: ({ name: string, joints: ({ name: string, axis: string, sign: number, slides: boolean, min: number | null, max: number | null, start: number })[], moves: boolean })[] } } | null>, problem: string, waits_for: string[] }
  write: { type: "write", number: number, revision: string, problem: string }
  change: { type: "change", number: number, edits: { start: number, end: number, text: string }[], problem: string }
}
type Message = Messages[keyof Messages]
type PageRequest =
  | { type: "stop" }
  | { type: "pause" }
  | { type: "resume", anyway?: boolean, beat?: number }
  | { type: "seek", beat: number }
  | { type: "speed", factor: number }
  | { type: "silence", muted: string[], soloed: string[] }
  | { type: "held" }
  | { type: "released" }
  | { type: "cue" }
  | { type: "key", key: string, held: boolean }
  | { type: "force", robot: string, sense: string, value: boolean | null }
  | { type: "restart" }
  | { type: "window", generation: number, from: number, to: number }
  | { type: "analyze", number: number, text: string, known?: number }
  | { type: "complete", number: number, offset: number }
  | { type: "explain", number: number, offset: number }
  | { type: "handle", number: number, offset: number, draws: boolean }
  | { type: "preview", number: number, known?: number }
  | { type: "write", number: number, text: string, revision: string }
  | { type: "change", number: number, change: { type: "place", start_poses: Record<string, { x: number, y: number, heading: number }> } | { type: "arrange", shape: "line" | "circle" | "grid", distance: number, facing: "in" | "out" } | { type: "tune", key: "beat" | "first_beat", value: number } | { type: "bend", offset: number, place: number[], freely: boolean } | { type: "lengthen", offset: number, steps: number, freely: boolean } | { type: "draw", robot: string, offset?: number, points: number[][], parts: number, begin?: number } | { type: "perform", robot: string, keys: number[][], end: number, parts: number, begin?: number } }
