// The one item in the status bar: what plays, where it is, and why a save did not play.

import { Disposable, StatusBarAlignment, ThemeColor, window, workspace } from "vscode";
import { beatAt, isOn, Transport } from "./clock";

const SHORTEST = 250; // ms between two changes
const LONGEST_REFUSAL = 60; // characters

type Server = "starts" | "missing" | "there";
const SERVER = { starts: "$(sync~spin) Improv starts", missing: "$(warning) Improv has no server", there: "" };

export class Status implements Disposable {
  private readonly item = window.createStatusBarItem("improv.status", StatusBarAlignment.Left, 10);
  private readonly listening = Disposable.from(
    window.onDidChangeActiveTextEditor(() => this.paint()),
    workspace.onDidChangeTextDocument(({ document, contentChanges }) => {
      if (document.languageId === "improv" && contentChanges.length > 0) this.accept(); // saving is said here, too
    }),
  );
  private transport?: Transport;
  private said = "";
  private refusal = "";
  private server: Server = "starts";
  private timer?: NodeJS.Timeout;

  constructor() {
    this.item.name = "Improv";
    this.paint();
  }

  take(transport: Transport | undefined): void {
    this.transport = transport;
    this.paint();
  }

  show(server: Server): void {
    this.server = server;
    this.paint();
  }

  /** Says in the tooltip what a save has the robots do. */
  say(line: string): void {
    this.said = line;
    this.accept();
  }

  /** Says why a save does not play, until the program is edited or plays. */
  refuse(line: string): void {
    this.refusal = line;
    this.paint();
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.listening.dispose();
    this.item.dispose();
  }

  private accept(): void {
    this.refusal = "";
    this.paint();
  }

  private paint(): void {
    clearTimeout(this.timer);
    if (window.activeTextEditor?.document.languageId !== "improv" && !isOn(this.transport)) return this.item.hide();
    const refused = shortened(this.refusal);
    const where = SERVER[this.server] || place(this.transport, refused !== "");
    this.item.text = refused ? `$(error) ${refused}  ${where}` : where;
    this.item.tooltip = this.refusal || (isOn(this.transport) && this.said) || "Play, stop, and more";
    const label = `Improv: ${this.item.text.replaceAll(/\$\([\w~-]+\) ?/g, "")}`;
    this.item.accessibilityInformation = { label, role: "button" };
    const isMissing = this.server === "missing";
    const isWrong = isMissing || refused !== "";
    this.item.backgroundColor = isWrong ? new ThemeColor("statusBarItem.warningBackground") : undefined;
    this.item.command = isMissing ? "improv.restartServer" : "improv.menu";
    this.item.show();

    if (this.transport?.state !== "playing") return;
    const left = Math.floor(beatAt(this.transport)) + 1 - beatAt(this.transport);
    this.timer = setTimeout(() => this.paint(), Math.max((left * 60_000) / this.transport.tempo, SHORTEST));
  }
}

/** What plays and where it is; in few words where there is something else to say. */
function place(transport: Transport | undefined, briefly: boolean): string {
  if (!transport) return "$(primitive-square) Improv";
  const { state, backend, tempo } = transport;
  const about = (pace: string): string => (briefly ? "" : ` · ${pace}${backend}`);
  const pace = `♩ ${Math.round(tempo * 10) / 10} · `;
  switch (state) {
    case "waiting":
      return `$(sync~spin) waiting${about("")}`;
    case "playing":
      return `$(play) ${beatOf(transport)}${about(pace)}`;
    case "paused":
      return `$(debug-pause) paused · ${beatOf(transport)}${about(pace)}`;
    case "ended":
      return `$(primitive-square) ended${about("")}`;
    case "stopped":
      return `$(primitive-square) stopped${about("")}`;
  }
}

/** Why a save did not play, without what the item says anyway. */
function shortened(refusal: string): string {
  const why = refusal.replace(/; the previous dance keeps playing$/, "");
  return why.length > LONGEST_REFUSAL ? `${why.slice(0, LONGEST_REFUSAL - 1).trimEnd()}…` : why;
}

/** Counts from 1, as people do. */
function beatOf(transport: Transport): string {
  const last = transport.beats === null ? "∞" : Math.ceil(transport.beats);
  const beat = Math.floor(beatAt(transport)) + 1;
  return `beat ${transport.beats === null ? beat : Math.min(beat, Math.ceil(transport.beats))}/${last}`;
}
