// What the server reports about playback, and where it is by now. No message comes for each beat: see docs/protocol.md.

export interface Transport {
  generation: number;
  state: "waiting" | "playing" | "paused" | "ended" | "stopped";
  backend: string;
  tempo: number; // beats per minute, with the speed included
  speed: number;
  beats: number | null; // null: it never ends
  beat: number; // at the time `wall`
  wall: number; // Unix time in seconds; server and extension run on the same machine
  muted: string[];
  soloed: string[];
  uri: string | null;
  page: string | null;
}

/** The beat at a Unix time in seconds, counted from 0. */
export function beatAt(transport: Transport, now: number = Date.now() / 1000): number {
  if (transport.state !== "playing") return transport.beat;
  const beat = transport.beat + ((now - transport.wall) * transport.tempo) / 60;
  return Math.max(0, Math.min(beat, transport.beats ?? Infinity));
}

/** Whether something plays, or may start on its own: there is something to stop. */
export function isActive(transport: Transport | undefined): transport is Transport {
  return transport !== undefined && ["waiting", "playing", "paused"].includes(transport.state);
}

/** Whether a robot stands still while its part plays. */
export function isSilent({ muted, soloed }: Transport, robot: string): boolean {
  return soloed.length > 0 ? !soloed.includes(robot) : muted.includes(robot);
}
