// The connection to the server, which does all the work; this is how VS Code shows it.

import { homedir } from "node:os";
import { commands, ConfigurationTarget, LogOutputChannel, Uri, window, workspace } from "vscode";
import {
  ClientCapabilities,
  CloseAction,
  ErrorAction,
  ErrorHandler,
  LanguageClient,
  MessageType,
  RevealOutputChannelOn,
  ShowMessageNotification,
  ShowMessageRequest,
  State,
  StaticFeature,
} from "vscode-languageclient/node";
import { showError, showInformation, showWarning, withoutLinks } from "./messages";
import { Transport } from "./transport";
import { Evaluated, Lit } from "./words";

/** Commands of the server that move no robot, and those that take a program. */
const HARMLESS = ["improv.stop", "improv.hush", "improv.history"];
const OF_A_PROGRAM = ["improv.play", "improv.only", "improv.before"];

const GIVEN_UP =
  "Improv's language server ended five times within three minutes, so it stays off. Save or play a program to start it again.";

/** Hears what the server reports to us beyond the standard protocol. */
export interface Listener {
  onTransport(transport: Transport): void;
  onLit(lit: Lit): void;
  onEvaluated(evaluated: Evaluated): void;
  /** The saved program plays: what the robots do. */
  onPlayed(line: string): void;
  /** The saved program does not play: why not. */
  onRefused(line: string): void;
  /** The server wants its page shown. */
  onPage(url: string): void;
}

/** A client that has not been started. */
export function createClient(server: string, log: LogOutputChannel, listener: Listener): LanguageClient {
  const client: LanguageClient = new QuietClient(
    "improv",
    "Improv",
    { command: server, options: { cwd: homedir() } }, // not the workspace, which may contain Python modules of its own
    {
      documentSelector: [{ language: "improv" }, { scheme: "file", pattern: "**/improv.toml" }],
      initializationOptions: settings(), // needed before the first document opens; the server asks again on changes
      outputChannel: log,
      revealOutputChannelOn: RevealOutputChannelOn.Never,
      initializationFailedHandler: () => false, // whoever starts the client reports it
      errorHandler: {
        error: () => ({ action: ErrorAction.Continue, handled: true }), // a server that can't be written to ends: see `closed`
        closed: async () => {
          const result = await usual.closed();
          return result.action === CloseAction.DoNotRestart ? { ...result, message: GIVEN_UP } : result;
        },
      },
      middleware: {
        workspace: { configuration: ({ items }) => items.map(settings) },
        sendRequest: (type, param, token, next) => next(type, param, token).catch(rethrowWithoutLinks),
        executeCommand: (name, given, next) => {
          if (!workspace.isTrusted && !HARMLESS.includes(name)) return askForTrust();
          // The client registers the server's commands. The command palette passes no arguments.
          return next(name, OF_A_PROGRAM.includes(name) ? [...programOf(given[0]), ...given.slice(1)] : given);
        },
        window: {
          showDocument: async (params, token, next) => {
            if (!isPage(params.uri)) return next(params, token);
            listener.onPage(params.uri);
            return { success: true };
          },
        },
      },
    },
  );
  const usual: ErrorHandler = client.createDefaultErrorHandler();
  client.registerFeature(new LiveMessages());
  client.onNotification("improv/transport", (transport: Transport) => listener.onTransport(transport));
  client.onNotification("improv/lit", (lit: Lit) => listener.onLit(lit));
  client.onNotification("improv/evaluated", (evaluated: Evaluated) => listener.onEvaluated(evaluated));
  client.onNotification("improv/settings", (chosen: Record<string, string>) => {
    for (const [name, value] of Object.entries(chosen)) {
      void workspace.getConfiguration("improv").update(name, value, ConfigurationTarget.Global);
    }
  });
  client.onNotification(ShowMessageNotification.type, ({ type, message }) => {
    // The result of each save belongs in the status bar: a notification would be in the way.
    if (message.startsWith("▶")) listener.onPlayed(message);
    else if (message.startsWith("✗")) listener.onRefused(message.slice(1).trim());
    else void messageOf(type)(message);
  });
  client.onRequest(ShowMessageRequest.type, async ({ type, message, actions = [] }) => {
    const title = await messageOf(type)(message, ...actions.map((action) => action.title));
    return actions.find((action) => action.title === title) ?? null;
  });
  return client;
}

/** Logs what goes wrong with the connection, and shows it only if a running server is lost. */
class QuietClient extends LanguageClient {
  override error(message: string, data?: unknown, showNotification?: boolean | "force"): void {
    super.error(message, data, false);
    if (showNotification === "force" && this.state === State.Running) void this.tell(message);
  }

  /** Asks what to do about a lost server. */
  private async tell(message: string): Promise<void> {
    switch (await showError(message, "Start Again", "Show Logs")) {
      case "Start Again":
        await commands.executeCommand("improv.restartServer");
        break;
      case "Show Logs":
        this.outputChannel.show();
    }
  }
}

/** Tells the server that we understand its own messages, show the beat from them, and change settings. */
class LiveMessages implements StaticFeature {
  fillClientCapabilities(capabilities: ClientCapabilities): void {
    capabilities.experimental = { ...capabilities.experimental, improv: { settings: true } };
    capabilities.window = { ...capabilities.window, workDoneProgress: false };
  }
  initialize(): void {}
  getState(): { kind: "static" } {
    return { kind: "static" };
  }
  clear(): void {}
}

/** The settings as the server gets them. In a workspace that is not trusted, a save plays nothing. */
function settings(): object {
  const given = workspace.getConfiguration("improv");
  if (!workspace.isTrusted) return { ...given, onSave: "off" };
  const set = given.inspect("onSave");
  const isSet = (set?.workspaceFolderValue ?? set?.workspaceValue ?? set?.globalValue) !== undefined;
  return isSet ? given : { ...given, onSave: null }; // so that the server may mention what else there is
}

/** VS Code itself shows why a command or a rename failed. */
function rethrowWithoutLinks(error: unknown): never {
  if (error instanceof Error) error.message = withoutLinks(error.message);
  throw error;
}

async function askForTrust(): Promise<void> {
  const choice = await showWarning("Robots move only in a workspace that you trust.", "Manage Trust");
  if (choice) await commands.executeCommand("workbench.trust.manage");
}

/** The program that is to play, as arguments: lenses pass its URI as text, and menus as an object. */
function programOf(given: unknown): string[] {
  const uri = given ?? activeProgram();
  return uri ? [String(uri)] : [];
}

/** The program in the active editor, if there is one. */
export function activeProgram(): Uri | undefined {
  const editors = [window.activeTextEditor, ...window.visibleTextEditors];
  return editors.find((each) => each?.document.languageId === "improv")?.document.uri;
}

function isPage(uri: string): boolean {
  const { scheme, authority } = Uri.parse(uri);
  return scheme === "http" && /^(127\.0\.0\.1|localhost):\d+$/.test(authority);
}

function messageOf(type: MessageType): typeof showError {
  switch (type) {
    case MessageType.Error:
      return showError;
    case MessageType.Warning:
      return showWarning;
    default:
      return showInformation;
  }
}
