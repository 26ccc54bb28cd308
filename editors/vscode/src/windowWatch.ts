// Whether the window is still there. One in a browser or of a remote machine may be gone, while we and what plays go on.

import { commands, Disposable, env, UIKind, window } from "vscode";
import { showWarning } from "./messages";

const PERIOD = 1000; // milliseconds between two questions to the window
const PATIENCE = 5; // questions in a row without an answer, until robots pause
const HIDDEN = 75; // the same if the window may be hidden: browsers let it answer once a minute

const PAUSED = "This window did not answer any more, so Improv paused the robots.";

export class WindowWatch implements Disposable {
  private timer?: NodeJS.Timeout;
  /** Questions since the latest answer. Not seconds: we may have been halted ourselves. */
  private unanswered = 0;
  private isSilent = false;
  /** Whether it shows the page, whose connection ends with the window, and stays if the window is only hidden. */
  private hasPage = false;
  /** Whether that connection has ended, and the window has answered nothing since. */
  private hasLostPage = false;

  /** Real robots may move from now on, or no longer, and the window shows the page, or not. */
  watch(moves: boolean, hasPage: boolean): void {
    if (this.hasPage && !hasPage) {
      this.hasLostPage = true;
      this.unanswered = 0;
    }
    this.hasPage = hasPage;
    const outlivesWindow = env.uiKind === UIKind.Web || env.remoteName !== undefined;
    if (moves && outlivesWindow) this.timer ??= setInterval(() => this.ask(), PERIOD);
    else this.dispose();
  }

  dispose(): void {
    clearInterval(this.timer);
    this.timer = undefined;
  }

  private get patience(): number {
    if (window.state.focused || this.hasLostPage) return PATIENCE;
    return this.hasPage ? Infinity : HIDDEN;
  }

  private ask(): void {
    this.unanswered += 1;
    if (this.unanswered > this.patience && !this.isSilent) {
      this.isSilent = true; // pause once: whoever plays again from elsewhere does so without this window
      void commands.executeCommand("improv.pause");
      void showWarning(PAUSED); // for when it is back
    }
    // Any command would do that the window itself obeys.
    void commands.executeCommand("setContext", "improv.isThere", true).then(() => this.hear());
  }

  private hear(): void {
    this.unanswered = 0;
    this.isSilent = this.hasLostPage = false;
  }
}
