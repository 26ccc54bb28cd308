// The page with the simulated robots, beside the text. A URL of the server opens it once, so each use asks for a new one.

import { commands, Disposable, env, Uri, ViewColumn, WebviewPanel, window } from "vscode";

export class PagePanel implements Disposable {
  private panel?: WebviewPanel;
  private column?: ViewColumn;
  private shown = ""; // the address of what the panel shows
  private asked = ""; // the address for which a URL is on its way
  private browses = false; // the next URL is for the browser

  constructor(private readonly extension: Uri) {}

  /** Asks the server to show the page; the URL comes to `show`. If there is no page yet, it starts the simulator. */
  async open(): Promise<void> {
    await commands.executeCommand("improv.page");
  }

  /** Opens the page in the browser. */
  async browse(): Promise<void> {
    this.browses = true;
    if (!(await commands.executeCommand("improv.page"))) this.browses = false;
  }

  /** Shows the page with a URL that the server has sent, and leaves the cursor in the text. */
  async show(url: string): Promise<void> {
    if (this.browses) {
      this.browses = false;
      await env.openExternal(Uri.parse(url));
      return;
    }
    if (!this.panel) {
      const column = { viewColumn: ViewColumn.Beside, preserveFocus: true };
      // The frame can do no more than the page around it, which has no script of its own.
      const options = { enableScripts: true, retainContextWhenHidden: true };
      this.panel = window.createWebviewPanel("improv.page", "Improv Robots", column, options);
      this.panel.iconPath = { light: this.icon("light"), dark: this.icon("dark") };
      this.column = this.panel.viewColumn;
      this.panel.onDidChangeViewState(() => this.reopenIfMoved());
      this.panel.onDidDispose(() => {
        this.panel = undefined;
        this.forget();
      });
    } else {
      this.panel.reveal(undefined, true);
    }
    const page = Uri.parse(url).with({ query: "" }).toString();
    if (page === this.shown) return;
    this.shown = page;
    const address = await externalAddress(url);
    if (this.panel && page === this.shown) this.panel.webview.html = html(address);
  }

  /** Opens the page again if it is open and now has another address. */
  async follow(page: string): Promise<void> {
    if (!this.panel || page === this.shown || page === this.asked) return;
    this.asked = page;
    await this.open();
  }

  /** What the panel shows is no longer valid, such as after the server has ended. */
  forget(): void {
    this.shown = this.asked = "";
  }

  /** VS Code loads a panel again that was moved, and its URL has been used. */
  private reopenIfMoved(): void {
    if (!this.panel || this.panel.viewColumn === this.column) return;
    this.column = this.panel.viewColumn;
    this.forget();
    void this.open();
  }

  dispose(): void {
    this.panel?.dispose();
  }

  private icon(theme: "light" | "dark"): Uri {
    return Uri.joinPath(this.extension, "icons", `${theme}.svg`);
  }
}

/** The address as seen from the window, which may be on another machine than the server. */
async function externalAddress(url: string): Promise<Uri> {
  const given = Uri.parse(url);
  const address = await env.asExternalUri(given);
  return address.with({ query: given.query }); // a proxy may have dropped the ticket
}

function html(address: Uri): string {
  return `<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8">
    <meta http-equiv="Content-Security-Policy"
      content="default-src 'none'; style-src 'unsafe-inline'; frame-src ${address.scheme}://${address.authority}">
    <title>Improv Robots</title>
    <style>
      html, body, iframe { margin: 0; padding: 0; border: 0; width: 100%; height: 100%; overflow: hidden; display: block }
      .vscode-light iframe, .vscode-high-contrast-light iframe { color-scheme: light }
      .vscode-dark iframe, .vscode-high-contrast:not(.vscode-high-contrast-light) iframe { color-scheme: dark }
    </style>
  </head>
  <body><iframe title="Simulated robots" allow="gamepad" src="${address.toString(true).replaceAll('"', "%22")}"></iframe></body>
</html>`;
}
