// What the item in the status bar offers.

import { commands, ConfigurationTarget, QuickPickItem, window, workspace } from "vscode";
import { Transport } from "./clock";

interface Choice extends QuickPickItem {
  do?: () => unknown;
}

const BACKENDS: Choice[] = [
  { label: "auto", description: "real robots where ROS 2 is found, else the simulator" },
  { label: "sim", description: "the simulator" },
  { label: "ros", description: "ROS 2" },
  { label: "both", description: "ROS 2, and the simulator beside it" },
];

/** Shows what can be done now with what plays. */
export async function showMenu(transport: Transport | undefined, robots: string[]): Promise<void> {
  const choices: Choice[] = [...conducting(transport), { label: "$(window) Open the page", do: command("improv.openPage") }];
  if (transport && robots.length > 0) {
    const { muted, soloed } = transport;
    choices.push({ label: "$(mute) Mute…", description: muted.join(", "), do: () => toggle("mute", robots, muted) });
    choices.push({ label: "$(person) Solo…", description: soloed.join(", "), do: () => toggle("solo", robots, soloed) });
  }
  const backend = workspace.getConfiguration("improv").get<string>("backend");
  choices.push({ label: "$(circuit-board) Play on…", ...(backend ? { description: backend } : {}), do: chooseBackend });
  choices.push({ label: "$(output) Show logs", do: command("improv.showLogs") });
  choices.push({ label: "$(refresh) Restart the language server", do: command("improv.restartServer") });
  await (await window.showQuickPick(choices, { title: "Improv" }))?.do?.();
}

function conducting(transport: Transport | undefined): Choice[] {
  const play = { label: "$(play) Play", do: command("improv.play") };
  const hush = { label: "$(primitive-square) Stop the robots", do: command("improv.hush") };
  const again = { label: "$(debug-restart) Play from the start", do: command("improv.restart") };
  switch (transport?.state) {
    case "playing":
      return [hush, { label: "$(debug-pause) Pause", do: command("improv.pause") }, again];
    case "paused":
      return [{ label: "$(debug-continue) Go on", do: command("improv.resume") }, hush, again];
    case "waiting":
      return [hush];
    default:
      return [play];
  }
}

function command(name: string): () => unknown {
  return () => commands.executeCommand(name);
}

async function toggle(what: "mute" | "solo", robots: string[], now: string[]): Promise<void> {
  const choices = robots.map((label) => ({ label, picked: now.includes(label) }));
  const title = what === "mute" ? "Robots that stand still" : "Robots that play alone";
  const chosen = await window.showQuickPick(choices, { title, canPickMany: true });
  if (!chosen) return;
  const wanted = chosen.map(({ label }) => label);
  for (const robot of robots.filter((each) => wanted.includes(each) !== now.includes(each))) {
    await commands.executeCommand(`improv.${what}`, robot);
  }
}

async function chooseBackend(): Promise<void> {
  const chosen = await window.showQuickPick(BACKENDS, { title: "What programs play on, from the next save on" });
  if (chosen) await workspace.getConfiguration("improv").update("backend", chosen.label, ConfigurationTarget.Global);
}
