// Starts the language server and shows what plays: in the status bar, in the text, and on the page beside it.

import { commands, env, ExtensionContext, version, window, workspace } from "vscode";
import { LanguageClient, State } from "vscode-languageclient/node";
import { createClient, Listener } from "./client";
import { isOn, Transport } from "./clock";
import { install } from "./install";
import { showMenu } from "./menu";
import { Evaluated } from "./moments";
import { browse, PagePanel } from "./page";
import { findServer, onSelectedPython } from "./server";
import { Status } from "./status";
import { PlayingWords } from "./words";

const FIRST_DANCE = `# The first dance: four steps and four quarter turns lead back home.
# Press Ctrl+Enter: the robot moves. Change a word, press it again. Ctrl+. stops it.
beat 60

turtle1 $ repeat 4 (forward left)
`;

// Escape pressed again within so many ms stops the robots. As a chord of two keys it would take away the key after it.
const TWICE = 600;

let client: LanguageClient | undefined;

export async function activate(context: ExtensionContext): Promise<void> {
  const log = window.createOutputChannel("Improv", { log: true });
  const status = new Status();
  const page = new PagePanel(context.extensionUri);
  const words = new PlayingWords(async (beat) => client?.sendRequest<Evaluated>("improv/moments", { beat }));
  context.subscriptions.push(log, status, page, words);

  let transport: Transport | undefined;
  let robots: string[] = [];
  let path = "";

  const take = (told: Transport | undefined): void => {
    transport = told;
    status.take(told);
    words.take(told);
    if (told?.page) void page.follow(told.page);
    void commands.executeCommand("setContext", "improv.playing", isOn(told));
  };
  const listener: Listener = {
    transport: take,
    evaluated: (evaluated) => {
      robots = Object.keys(evaluated.robots);
      words.expect(evaluated);
    },
    said: (line) => status.say(line),
    refused: (line) => status.refuse(line),
    page: (url) => void page.show(url),
  };

  const startOnce = async (): Promise<void> => {
    status.show("starts");
    await stop();
    path = (await findServer(context)) ?? "";
    if (!path) {
      status.show("missing");
      return void offer();
    }
    log.info(`starting ${path}`);
    client = createClient(path, log, listener);
    client.onDidChangeState(({ newState }) => {
      void commands.executeCommand("setContext", "improv.ready", newState === State.Running);
      if (newState === State.Stopped) take(undefined);
    });
    try {
      await client.start();
      status.show("there");
    } catch (error) {
      log.error(error as Error);
      status.show("missing");
      void offer(path);
    }
  };
  const failed = (error: Error): void => {
    log.error(error);
    status.show("missing");
    void window.showErrorMessage(`Improv's language server can't be started: ${error.message}`);
  };
  let starting = Promise.resolve();
  const start = (): Promise<void> => (starting = starting.then(startOnce).catch(failed));

  const offer = async (broken?: string): Promise<void> => {
    const problem = broken ? `${broken} does not start` : "no improv-ls was found";
    const choices = ["Install it…", "Say where it is", ...(broken ? ["Show logs"] : [])];
    const message = `Improv needs its language server, and ${problem}.`;
    switch (await window.showWarningMessage(message, ...choices)) {
      case "Install it…":
        if (await install(context, log)) await start();
        break;
      case "Say where it is":
        await commands.executeCommand("workbench.action.openSettings", "improv.server.path");
        break;
      case "Show logs":
        log.show();
    }
  };

  const register = (name: string, run: () => unknown): void => {
    context.subscriptions.push(commands.registerCommand(name, run));
  };
  register("improv.restartServer", start);
  register("improv.showLogs", () => log.show());
  register("improv.showVersions", async () => {
    const server = client?.initializeResult?.serverInfo;
    const lines = [
      `Extension ${context.extension.packageJSON.version}`,
      server ? `${server.name} ${server.version} (${path})` : "no language server",
      `VS Code ${version}`,
    ].join(", ");
    if ((await window.showInformationMessage(lines, "Copy")) === "Copy") await env.clipboard.writeText(lines);
  });
  register("improv.menu", () => showMenu(transport, robots));
  // Where there is no page yet, the server starts the simulator, and asks for its page to be shown.
  register("improv.openPage", () => (transport?.page ? page.show(transport.page) : commands.executeCommand("improv.page")));
  register("improv.browsePage", () => transport?.page && browse(transport.page));
  let escaped = 0;
  register("improv.escape", async () => {
    const isSecond = Date.now() - escaped < TWICE;
    escaped = isSecond ? 0 : Date.now();
    if (isSecond) await commands.executeCommand("improv.hush");
  });
  register("improv.openFirstDance", async () => {
    const document = await workspace.openTextDocument({ language: "improv", content: FIRST_DANCE });
    await window.showTextDocument(document);
  });

  context.subscriptions.push(
    workspace.onDidGrantWorkspaceTrust(() => {
      // The server asks for its settings anew, and hears that saving plays. One that was not found may be seen now.
      if (client?.isRunning()) void client.sendNotification("workspace/didChangeConfiguration", { settings: null });
      else void start();
    }),
    // Said of every restricted setting when trust is granted, changed or not.
    workspace.onDidChangeConfiguration(async (event) => {
      if (event.affectsConfiguration("improv.server.path") && (await findServer(context)) !== path) await start();
    }),
  );
  void onSelectedPython(() => client?.isRunning() || void start()).then((it) => it && context.subscriptions.push(it));
  void start();
}

/** Ends the server; it stops its robots before. */
export function deactivate(): Promise<void> {
  return stop();
}

async function stop(): Promise<void> {
  const ending = client;
  client = undefined;
  await ending?.dispose().catch(() => undefined); // it may have ended by itself
}
