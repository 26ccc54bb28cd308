// Puts the extension together: the language server, what shows its work, and the commands.

import { ExtensionContext, window } from "vscode";
import { registerCommands } from "./commands";
import { NowPlaying } from "./nowPlaying";
import { Server } from "./server";

let server: Server | undefined;

export function activate(context: ExtensionContext): void {
  const log = window.createOutputChannel("Improv", { log: true });
  const playing = new NowPlaying(context.extensionUri);
  server = new Server(context, log, playing, (state) => playing.onServerState(state));
  context.subscriptions.push(log, playing, server, registerCommands(context, log, server, playing));
  void server.restart();
}

export async function deactivate(): Promise<void> {
  await server?.stop();
}
