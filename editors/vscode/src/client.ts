// The connection to the server. All that Improv can do is in there; here is how VS Code shows it.

import { homedir } from "node:os";
import { commands, LogOutputChannel, Uri, window, workspace } from "vscode";
import {
  ClientCapabilities,
  LanguageClient,
  MessageType,
  RevealOutputChannelOn,
  ShowMessageNotification,
  StaticFeature,
} from "vscode-languageclient/node";
import { Transport } from "./clock";
import { Evaluated } from "./moments";

/** What the server tells us, beyond what every editor is told. */
export interface Listener {
  transport(transport: Transport): void;
  evaluated(evaluated: Evaluated): void;
  /** A save plays: what the robots do. */
  said(line: string): void;
  /** A save does not play: why. */
  refused(line: string): void;
  /** The page is wanted. */
  page(url: string): void;
}

/** A client that is still to be started. */
export function createClient(server: string, log: LogOutputChannel, listener: Listener): LanguageClient {
  const client = new LanguageClient(
    "improv",
    "Improv",
    { command: server, options: { cwd: homedir() } }, // not the workspace: that may bring modules of its own
    {
      documentSelector: [{ language: "improv" }],
      initializationOptions: settings(), // known before the first document is opened; the server asks for changes
      outputChannel: log,
      revealOutputChannelOn: RevealOutputChannelOn.Never,
      middleware: {
        workspace: { configuration: ({ items }) => items.map(settings) },
        executeCommand: (name, given, next) => {
          if (!workspace.isTrusted && name !== "improv.hush") return askForTrust();
          // The client registers the server's commands. From the palette they come without arguments.
          return next(name, name === "improv.play" && given.length === 0 ? activeProgram() : given);
        },
        window: {
          showDocument: async (params, token, next) => {
            if (!isPage(params.uri)) return next(params, token);
            listener.page(params.uri);
            return { success: true };
          },
        },
      },
    },
  );
  client.registerFeature(new LiveMessages());
  client.onNotification("improv/transport", (transport: Transport) => listener.transport(transport));
  client.onNotification("improv/evaluated", (evaluated: Evaluated) => listener.evaluated(evaluated));
  client.onNotification(ShowMessageNotification.type, ({ type, message }) => {
    // The answer to each save belongs in the status bar: a note that pops up would be in the way.
    if (message.startsWith("▶")) listener.said(message);
    else if (message.startsWith("✗")) listener.refused(message.slice(1).trim());
    else if (type === MessageType.Error) void window.showErrorMessage(message);
    else if (type === MessageType.Warning) void window.showWarningMessage(message);
    else void window.showInformationMessage(message);
  });
  return client;
}

/** Tells the server that we take its own messages, and that we show the beat by them. */
class LiveMessages implements StaticFeature {
  fillClientCapabilities(capabilities: ClientCapabilities): void {
    capabilities.experimental = { ...capabilities.experimental, improv: true };
    capabilities.window = { ...capabilities.window, workDoneProgress: false };
  }
  initialize(): void {}
  getState(): { kind: "static" } {
    return { kind: "static" };
  }
  clear(): void {}
}

/** The settings as the server gets them. In a workspace that is not trusted, saving plays nothing. */
function settings(): object {
  const given = workspace.getConfiguration("improv");
  return workspace.isTrusted ? given : { ...given, onSave: "off" };
}

async function askForTrust(): Promise<void> {
  const manage = "Manage trust";
  const answer = await window.showWarningMessage("Robots move only in a workspace that you trust.", manage);
  if (answer === manage) await commands.executeCommand("workbench.trust.manage");
}

/** The program in front: its URI, as arguments. */
function activeProgram(): string[] {
  const editors = [window.activeTextEditor, ...window.visibleTextEditors];
  const editor = editors.find((each) => each?.document.languageId === "improv");
  return editor ? [editor.document.uri.toString()] : [];
}

function isPage(uri: string): boolean {
  const { scheme, authority } = Uri.parse(uri);
  return scheme === "http" && /^(127\.0\.0\.1|localhost):\d+$/.test(authority);
}
