// The extension's own commands. The server's commands are registered by its client.

import { commands, Disposable, ExtensionContext, LogOutputChannel } from "vscode";
import { holdKey } from "./keys";
import { stopOnSecondEscape } from "./escape";
import { openFirstDance } from "./firstDance";
import { showHistory } from "./history";
import { showMenu } from "./menu";
import { NowPlaying } from "./nowPlaying";
import { Server } from "./server";
import { transcribeRecording } from "./transcribe";
import { showVersions } from "./versions";

/** Does what the code actions of a kind at the cursor offer: the first of them, or if there are several, asks which. */
function choose(kind: string, apply: "first" | "ifSingle" = "first"): Thenable<unknown> {
  return commands.executeCommand("editor.action.codeAction", { kind, apply });
}

export function registerCommands(
  context: ExtensionContext,
  log: LogOutputChannel,
  server: Server,
  playing: NowPlaying,
): Disposable {
  const own: Record<string, (argument?: string) => unknown> = {
    "improv.playWhenReady": () => server.playWhenReady(),
    "improv.playThis": () => server.playThis("improv.play"),
    "improv.playOnlyThis": () => server.playThis("improv.only"),
    "improv.restartServer": () => server.restart(),
    "improv.showLogs": () => log.show(),
    "improv.showVersions": () => showVersions(context, server),
    "improv.menu": () => showMenu(playing.transport),
    "improv.openPage": () => playing.page.open(),
    "improv.browsePage": () => playing.page.browse(),
    "improv.holdKey": () => holdKey(),
    "improv.escape": stopOnSecondEscape(),
    "improv.showHistory": () => showHistory(),
    "improv.transcribeRecording": () => transcribeRecording(),
    "improv.openFirstDance": () => openFirstDance(),
    "improv.tryName": () => choose("improv.play.name"),
    "improv.playScene": () => choose("improv.play.scene"),
    "improv.muteHere": () => choose("improv.mute", "ifSingle"),
    "improv.soloHere": () => choose("improv.solo", "ifSingle"),
  };
  return Disposable.from(...Object.entries(own).map(([name, run]) => commands.registerCommand(name, run)));
}
