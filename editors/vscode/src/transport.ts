// What the server reports about playback, at every change and at every beat: see docs/protocol.md.

export interface Transport {
  state: "waiting" | "playing" | "paused" | "ended" | "stopped";
  backend: string;
  tempo: number; // beats per minute, with the speed included
  counted: string; // the beat, counted from 1: "beat 3/8"
  muted: string[];
  soloed: string[];
  silenced: string; // these two as people read them: "ada muted"
  robots: string[];
  page: string | null;
  framed: number; // how many windows show the page
  real: boolean; // whether real robots play
}

/** Whether something plays, or may start on its own: there is something to stop. */
export function isActive(transport: Transport | undefined): transport is Transport {
  return transport !== undefined && ["waiting", "playing", "paused"].includes(transport.state);
}
