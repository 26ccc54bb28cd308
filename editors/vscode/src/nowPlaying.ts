// What plays now, as the server reported it last, and every place in the window that shows it.

import { commands, Disposable, Uri } from "vscode";
import { Listener } from "./client";
import { showWarning } from "./messages";
import { PagePanel } from "./page";
import { ServerState } from "./server";
import { Status } from "./status";
import { isActive, Transport } from "./transport";
import { WindowWatch } from "./windowWatch";
import { Evaluated, Lit, LitWords } from "./words";

const INTERRUPTED = "Improv's language server ended unexpectedly, so the robots stopped. It runs again: save to play.";

export class NowPlaying implements Listener, Disposable {
  transport?: Transport;
  readonly page: PagePanel;
  private readonly status = new Status();
  private readonly words = new LitWords();
  private readonly window = new WindowWatch();
  /** Whether the server ended by itself while robots danced, and has not come back yet. */
  private wasInterrupted = false;

  constructor(extension: Uri) {
    this.page = new PagePanel(extension);
  }

  onServerState(state: ServerState): void {
    this.status.setServer(state);
    if (state === "stopped") this.wasInterrupted = false; // a person starts it again
    if (state === "lost" && isActive(this.transport)) this.wasInterrupted = true;
    if (state === "running") {
      if (this.wasInterrupted) void showWarning(INTERRUPTED);
      this.wasInterrupted = false;
      return;
    }
    this.setTransport(undefined);
    this.page.forget();
  }

  onTransport(transport: Transport): void {
    this.setTransport(transport);
    if (transport.page) void this.page.follow(transport.page);
  }

  onLit(lit: Lit): void {
    this.words.show(lit);
  }

  onEvaluated(evaluated: Evaluated): void {
    this.words.flash(evaluated);
  }

  onPlayed(line: string): void {
    this.status.setPlayed(line);
  }

  onRefused(line: string): void {
    this.status.setRefused(line);
  }

  onPage(url: string): void {
    void this.page.show(url);
  }

  dispose(): void {
    Disposable.from(this.status, this.page, this.words, this.window).dispose();
  }

  private setTransport(transport: Transport | undefined): void {
    this.transport = transport;
    this.status.setTransport(transport);
    this.window.watch(isActive(transport) && transport.real, transport !== undefined && transport.framed > 0);
    if (!isActive(transport)) this.words.show(undefined);
    void commands.executeCommand("setContext", "improv.playing", isActive(transport));
  }
}
