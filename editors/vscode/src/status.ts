// The status bar item: what plays, the current beat, and why a save did not play.

import { Disposable, StatusBarAlignment, ThemeColor, window, workspace } from "vscode";
import { ServerState } from "./server";
import { isActive, Transport } from "./transport";

const LONGEST_PROBLEM = 60; // characters

const SERVER: Record<ServerState, string> = {
  starting: "$(sync~spin) Starting Improv…",
  running: "",
  stopped: "$(warning) Improv: server not running",
  lost: "$(warning) Improv: server not running",
  missing: "$(warning) Improv: server not found",
};

export class Status implements Disposable {
  private readonly item = window.createStatusBarItem("improv.status", StatusBarAlignment.Left, 10);
  private readonly listening = Disposable.from(
    window.onDidChangeActiveTextEditor(() => this.paint()),
    workspace.onDidChangeTextDocument(({ document, contentChanges }) => {
      if (document.languageId === "improv" && contentChanges.length > 0) this.accept(); // a save is an event without changes
    }),
  );
  private transport?: Transport;
  private played = "";
  private refused = "";
  private server: ServerState = "starting";

  constructor() {
    this.item.name = "Improv";
    this.paint();
  }

  setTransport(transport: Transport | undefined): void {
    this.transport = transport;
    this.paint();
  }

  setServer(server: ServerState): void {
    this.server = server;
    if (server !== "running") this.played = this.refused = ""; // the next server knows nothing of it
    this.paint();
  }

  /** Shows in the tooltip what the robots do since a save. */
  setPlayed(line: string): void {
    this.played = line;
    this.accept();
  }

  /** Shows why a save does not play, until the program is edited or plays. */
  setRefused(line: string): void {
    this.refused = line;
    this.paint();
  }

  dispose(): void {
    this.listening.dispose();
    this.item.dispose();
  }

  private accept(): void {
    this.refused = "";
    this.paint();
  }

  private paint(): void {
    if (window.activeTextEditor?.document.languageId !== "improv" && !isActive(this.transport)) return this.item.hide();
    const problem = shortened(this.refused);
    const current = SERVER[this.server] || describe(this.transport, problem !== "");
    this.item.text = problem ? `$(error) ${problem}  ${current}` : current;
    const isDown = this.server === "missing" || this.server === "stopped" || this.server === "lost";
    const use = isDown ? "Start the language server, or install it" : "Play, stop, and more. Beats count from 1.";
    this.item.tooltip = this.refused || (isActive(this.transport) && this.played) || use;
    const label = `Improv: ${this.item.text.replaceAll(/\$\([\w~-]+\) ?|Improv: /g, "")}`;
    this.item.accessibilityInformation = { label, role: "button" };
    const isWarning = isDown || problem !== "";
    this.item.backgroundColor = isWarning ? new ThemeColor("statusBarItem.warningBackground") : undefined;
    this.item.command = isDown ? "improv.restartServer" : "improv.menu";
    this.item.show();
  }
}

/** What plays and the current beat; briefly if there is a problem to show as well. */
function describe(transport: Transport | undefined, briefly: boolean): string {
  if (!transport) return "$(primitive-square) Improv";
  const { state, backend, tempo, silenced } = transport;
  const counted = silenced ? `${transport.counted} · ${silenced}` : transport.counted;
  const details = (pace: string): string => (briefly ? "" : ` · ${pace}${backend}`);
  const pace = `${Math.round(tempo * 10) / 10} beats/min · `;
  switch (state) {
    case "waiting":
      return `$(sync~spin) Improv: waiting${details("")}`;
    case "playing":
      return `$(play) ${counted}${details(pace)}`;
    case "paused":
      return `$(debug-pause) paused · ${counted}${details(pace)}`;
    case "ended":
      return `$(primitive-square) Improv: ended${details("")}`;
    case "stopped":
      return `$(primitive-square) Improv: stopped${details("")}`;
  }
}

/** Why a save did not play, without what the item shows anyway. */
function shortened(refused: string): string {
  const why = refused.replace(/; the previous dance keeps playing$/, "");
  return why.length > LONGEST_PROBLEM ? `${why.slice(0, LONGEST_PROBLEM - 1).trimEnd()}…` : why;
}
