// The menu of the status bar item.

import { commands, ConfigurationTarget, QuickPickItem, window, workspace } from "vscode";
import { Transport } from "./transport";

interface Choice extends QuickPickItem {
  run?: () => unknown;
}

const BACKENDS: Choice[] = [
  { label: "auto", description: "real robots if ROS 2 is found, otherwise the simulator" },
  { label: "sim", description: "the simulator" },
  { label: "ros", description: "ROS 2" },
  { label: "both", description: "ROS 2 and the simulator" },
];

/** Offers what makes sense for what plays now. */
export async function showMenu(transport: Transport | undefined): Promise<void> {
  const choices: Choice[] = [...playback(transport), { label: "$(window) Show Robots", run: command("improv.openPage") }];
  if (transport && transport.robots.length > 0) {
    const { muted, soloed, robots } = transport;
    choices.push({ label: "$(mute) Mute…", description: muted.join(", "), run: () => toggle("mute", robots, muted) });
    choices.push({ label: "$(person) Solo…", description: soloed.join(", "), run: () => toggle("solo", robots, soloed) });
  }
  const backend = workspace.getConfiguration("improv").get<string>("backend");
  choices.push({ label: "$(circuit-board) Play On…", ...(backend ? { description: backend } : {}), run: chooseBackend });
  choices.push({ label: "$(output) Show Logs", run: command("improv.showLogs") });
  choices.push({ label: "$(refresh) Restart Language Server", run: command("improv.restartServer") });
  await (await window.showQuickPick(choices, { title: "Improv" }))?.run?.();
}

function playback(transport: Transport | undefined): Choice[] {
  const play = { label: "$(play) Play", run: command("improv.play") };
  const stop = { label: "$(primitive-square) Stop Robots", run: command("improv.stop") };
  const restart = { label: "$(debug-restart) Play from the Beginning", run: command("improv.restart") };
  switch (transport?.state) {
    case "playing":
      return [stop, { label: "$(debug-pause) Pause", run: command("improv.pause") }, restart];
    case "paused":
      return [{ label: "$(debug-continue) Resume", run: command("improv.resume") }, stop, restart];
    case "waiting":
      return [stop];
    default:
      return [play];
  }
}

function command(name: string): () => unknown {
  return () => commands.executeCommand(name);
}

async function toggle(what: "mute" | "solo", robots: string[], now: string[]): Promise<void> {
  const choices = robots.map((label) => ({ label, picked: now.includes(label) }));
  const title = what === "mute" ? "Mute: robots to keep still" : "Solo: the only robots to play";
  const chosen = await window.showQuickPick(choices, { title, canPickMany: true });
  if (!chosen) return;
  const wanted = chosen.map(({ label }) => label);
  for (const robot of robots.filter((each) => wanted.includes(each) !== now.includes(each))) {
    await commands.executeCommand(`improv.${what}`, robot);
  }
}

async function chooseBackend(): Promise<void> {
  const chosen = await window.showQuickPick(BACKENDS, { title: "Where to play, starting with the next save" });
  if (chosen) await workspace.getConfiguration("improv").update("backend", chosen.label, ConfigurationTarget.Global);
}
