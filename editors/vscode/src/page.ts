// The page with the simulated robots, beside the text.

import { Disposable, env, Uri, ViewColumn, WebviewPanel, window } from "vscode";

export class PagePanel implements Disposable {
  private panel?: WebviewPanel;
  private url = "";

  constructor(private readonly extension: Uri) {}

  /** Shows the page at an address, and leaves the cursor in the text. */
  async show(url: string): Promise<void> {
    if (!this.panel) {
      const column = { viewColumn: ViewColumn.Beside, preserveFocus: true };
      // The frame can do no more than the page around it, which has no script of its own.
      const options = { enableScripts: true, retainContextWhenHidden: true };
      this.panel = window.createWebviewPanel("improv.page", "Improv Robots", column, options);
      this.panel.iconPath = { light: this.icon("light"), dark: this.icon("dark") };
      this.panel.onDidDispose(() => {
        this.panel = undefined;
        this.url = "";
      });
    } else {
      this.panel.reveal(undefined, true);
    }
    await this.follow(url);
  }

  /** Loads another address, if the page is open. */
  async follow(url: string): Promise<void> {
    if (!this.panel || url === this.url) return;
    const address = await externalAddress(url);
    if (!this.panel || url === this.url) return; // closed meanwhile, or another call was faster
    this.url = url;
    this.panel.webview.html = html(address);
  }

  dispose(): void {
    this.panel?.dispose();
  }

  private icon(theme: "light" | "dark"): Uri {
    return Uri.joinPath(this.extension, "icons", `${theme}.svg`);
  }
}

/** Opens the page in the browser. */
export async function browse(url: string): Promise<void> {
  await env.openExternal(Uri.parse(url));
}

/** The address as seen from the window, which may be on another machine than the server. */
async function externalAddress(url: string): Promise<Uri> {
  const given = Uri.parse(url);
  const address = await env.asExternalUri(given);
  return address.with({ query: given.query }); // a proxy may have dropped the token
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
  <body><iframe title="Simulated robots" src="${address.toString(true).replaceAll('"', "%22")}"></iframe></body>
</html>`;
}
