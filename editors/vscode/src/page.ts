// The page on which the simulated robots move, beside the text.

import { Disposable, env, Uri, ViewColumn, WebviewPanel, window } from "vscode";

export class PagePanel implements Disposable {
  private panel?: WebviewPanel;
  private url = "";

  constructor(private readonly extension: Uri) {}

  /** Shows the page of an address, and leaves the cursor in the text. */
  async show(url: string): Promise<void> {
    if (!this.panel) {
      const place = { viewColumn: ViewColumn.Beside, preserveFocus: true };
      // Scripts are for the page in the frame, which can have no more rights than what is around it; that has none.
      const options = { enableScripts: true, retainContextWhenHidden: true };
      this.panel = window.createWebviewPanel("improv.page", "Improv: robots", place, options);
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

  /** Goes where the page is now, if it is shown. */
  async follow(url: string): Promise<void> {
    if (!this.panel || url === this.url) return;
    const address = await reachable(url);
    if (!this.panel || url === this.url) return; // closed meanwhile, or another was faster
    this.url = url;
    this.panel.webview.html = framed(address);
  }

  dispose(): void {
    this.panel?.dispose();
  }

  private icon(theme: "light" | "dark"): Uri {
    return Uri.joinPath(this.extension, "icons", `${theme}.svg`);
  }
}

/** Opens the page in a browser of its own. */
export async function browse(url: string): Promise<void> {
  await env.openExternal(Uri.parse(url));
}

/** The address as seen from where the window is, which may be another machine than the one with the server. */
async function reachable(url: string): Promise<Uri> {
  const given = Uri.parse(url);
  const address = await env.asExternalUri(given);
  return address.with({ query: given.query }); // a proxy may have dropped the token
}

function framed(address: Uri): string {
  return `<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8">
    <meta http-equiv="Content-Security-Policy"
      content="default-src 'none'; style-src 'unsafe-inline'; frame-src ${address.scheme}://${address.authority}">
    <title>Improv: robots</title>
    <style>
      html, body, iframe { margin: 0; padding: 0; border: 0; width: 100%; height: 100%; overflow: hidden; display: block }
      .vscode-light iframe, .vscode-high-contrast-light iframe { color-scheme: light }
      .vscode-dark iframe, .vscode-high-contrast:not(.vscode-high-contrast-light) iframe { color-scheme: dark }
    </style>
  </head>
  <body><iframe title="The page with the robots" src="${address.toString(true).replaceAll('"', "%22")}"></iframe></body>
</html>`;
}
