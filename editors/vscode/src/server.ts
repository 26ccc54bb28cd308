// The language server: it starts, stops and restarts, and says what failed.

import { commands, Disposable, ExtensionContext, LogOutputChannel, TextDocument, TextDocumentSaveReason, window, workspace } from "vscode";
import { InitializeResult, LanguageClient, Range, State } from "vscode-languageclient/node";
import { activeProgram, createClient, Listener } from "./client";
import { install } from "./install";
import { showWarning } from "./messages";
import { findServer, onSelectedPython } from "./serverPath";

/** Milliseconds in which the server stops its robots and ends, also on a busy machine; then it is killed. */
const END_LIMIT = 10_000;

/** `lost`: it ended by itself. */
export type ServerState = "starting" | "running" | "stopped" | "lost" | "missing";

/** What a person asked for while no server ran: that what was saved plays, or a command with the program or a range of it. */
type Wish = { saved: string } | { command: string; some: Range[] };

export class Server implements Disposable {
  /** The program that was started last; empty if none was found. */
  path = "";
  private client?: LanguageClient;
  private starting = Promise.resolve();
  /** The number of the latest call of `restart` or `stop`: an earlier one that still waits gives up. */
  private latest = 0;
  private state: ServerState = "stopped";
  /** What a person saves at the moment; undefined if VS Code saves it on its own. */
  private saving?: TextDocument;
  /** What is to be done with each program once the server runs. */
  private readonly waiting = new Map<string, Wish>();
  private readonly listening: Disposable[];

  constructor(
    private readonly context: ExtensionContext,
    private readonly log: LogOutputChannel,
    private readonly listener: Listener,
    private readonly onState: (state: ServerState) => void,
  ) {
    this.listening = [
      workspace.onDidGrantWorkspaceTrust(() => this.onTrust()),
      workspace.onWillSaveTextDocument(({ document, reason }) => {
        this.saving = reason === TextDocumentSaveReason.Manual ? document : undefined;
      }),
      workspace.onDidSaveTextDocument((document) => {
        if (document === this.saving) this.remember(document);
      }),
      workspace.onDidChangeConfiguration(async (event) => {
        // VS Code reports every restricted setting when trust is granted, whether it changed or not.
        if (event.affectsConfiguration("improv.server.path") && (await findServer(context)) !== this.path) this.restart();
      }),
    ];
    void onSelectedPython(() => this.startIfStopped()).then((it) => it && this.listening.push(it));
  }

  get info(): InitializeResult["serverInfo"] {
    return this.client?.initializeResult?.serverInfo;
  }

  /** Plays the selection, or the line of the cursor, by this command: the others dance on, or stop. */
  playThis(command: "improv.play" | "improv.only"): void {
    const editor = window.activeTextEditor;
    if (editor?.document.languageId !== "improv") return;
    const { start, end } = editor.selection;
    this.playWhenReady(command, Range.create(start.line, start.character, end.line, end.character));
  }

  /** Plays the program in the active editor, or a range of it, once the server runs. Starts the server if need be. */
  playWhenReady(command = "improv.play", ...some: Range[]): void {
    const program = activeProgram()?.toString();
    if (program) this.waiting.set(program, { command, some });
    if (this.state === "running") void this.playWaiting();
    else if (this.state !== "starting") void this.restart();
  }

  /** Stops the server, if there is one, and starts it again. What a person asks for meanwhile waits for the next one. */
  restart(): Promise<void> {
    const stopped = this.stop("starting"); // at once: a server that hangs while it starts must not hold up the next one
    const call = this.latest;
    this.starting = Promise.all([this.starting, stopped])
      .then(() => this.start(call))
      .catch((error: Error) => this.reportFailure(error));
    return this.starting;
  }

  /** Ends the server, which stops its robots first. */
  async stop(next: "stopped" | "starting" = "stopped"): Promise<void> {
    const client = this.client;
    this.client = undefined;
    this.latest += 1;
    this.show(next);
    await client?.dispose(END_LIMIT).catch(() => undefined); // it may have ended on its own
  }

  dispose(): void {
    this.listening.forEach((each) => each.dispose());
  }

  private async start(call: number): Promise<void> {
    const path = (await findServer(this.context)) ?? "";
    if (call !== this.latest) return;
    this.path = path;
    if (!path) {
      this.show("missing");
      return void this.offer("Improv can't find its language server, improv-ls.");
    }
    this.log.info(`starting ${path}`);
    const client = createClient(path, this.log, this.listener);
    this.client = client;
    client.onDidChangeState(async ({ newState }) => {
      if (client !== this.client) return;
      this.show(stateOf(newState));
      if (newState !== State.Running) return;
      await client.start(); // it runs before it has the open programs, also if the client itself starts it again
      if (client === this.client) await this.playWaiting();
    });
    await client.start().catch((error: Error) => {
      if (client === this.client) throw error; // otherwise it was stopped while it started
    });
    if (client !== this.client) await client.dispose(END_LIMIT).catch(() => undefined); // it was too early to stop it then
  }

  private async playWaiting(): Promise<void> {
    const programs = [...this.waiting];
    this.waiting.clear();
    for (const [program, wish] of programs) {
      if ("some" in wish) await commands.executeCommand(wish.command, program, ...wish.some);
      // The server has the text as it is by now, but what was saved is what plays, if a save plays anything.
      else await this.client?.sendNotification("textDocument/didSave", { textDocument: { uri: program }, text: wish.saved });
    }
  }

  /** The server hears of a save itself, unless it is starting, or has ended too often to be started without being asked. */
  private remember(document: TextDocument): void {
    if (document.languageId !== "improv" || !["starting", "lost"].includes(this.state)) return;
    this.waiting.set(document.uri.toString(), { saved: document.getText() });
    if (this.state === "lost") void this.restart();
  }

  private reportFailure(error: Error): void {
    this.log.error(error);
    this.waiting.clear();
    this.show("stopped");
    void this.offer(`Improv can't start its language server, ${this.path}.`, "Show Logs");
  }

  private async offer(problem: string, ...more: "Show Logs"[]): Promise<void> {
    switch (await showWarning(problem, "Install…", "Set Server Path…", ...more)) {
      case "Install…":
        if (await install(this.context, this.log)) await this.restart();
        break;
      case "Set Server Path…":
        await commands.executeCommand("workbench.action.openSettings", "improv.server.path");
        break;
      case "Show Logs":
        this.log.show();
    }
  }

  private onTrust(): void {
    // The server asks for its settings again and learns that a save plays. One that was hidden may be found now.
    if (this.client?.isRunning()) {
      void this.client.sendNotification("workspace/didChangeConfiguration", { settings: null });
    } else {
      void this.restart();
    }
  }

  private startIfStopped(): void {
    if (!this.client?.isRunning()) void this.restart();
  }

  private show(state: ServerState): void {
    this.state = state;
    if (state === "missing" || state === "lost") this.waiting.clear();
    void commands.executeCommand("setContext", "improv.ready", state === "running");
    this.onState(state);
  }
}

function stateOf(state: State): ServerState {
  switch (state) {
    case State.Starting:
      return "starting";
    case State.Running:
      return "running";
    default:
      return "lost";
  }
}
