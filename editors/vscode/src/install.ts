// Makes an environment for the server in the extension's own storage, after saying what will be in it.

import { execFile } from "node:child_process";
import { mkdir, readdir, rm } from "node:fs/promises";
import { basename, join } from "node:path";
import { promisify } from "node:util";
import { ExtensionContext, LogOutputChannel, ProgressLocation, window } from "vscode";
import { onPath, ownEnvironment, ownServer, selectedPython } from "./server";

declare const REQUIREMENTS: string[]; // from pyproject.toml, put in by build.mjs

const run = promisify(execFile);
const FITS = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";

/** Asks, installs, and says what went wrong, if so. Whether there is a server now. */
export async function install(context: ExtensionContext, log: LogOutputChannel): Promise<boolean> {
  const python = await findPython();
  if (!python) {
    const packages = process.platform === "linux" ? " (on Debian and Ubuntu, with the package python3-venv)" : "";
    void window.showErrorMessage(`Improv needs Python 3.11 or newer: install it${packages}, and try again.`);
    return false;
  }
  const environment = ownEnvironment(context);
  const detail = [
    `It gets a Python environment of its own, made with ${python}, in`,
    environment,
    `In there come Improv ${context.extension.packageJSON.version}, which is in this extension, and by pip from the ` +
      `internet what it is made with: ${REQUIREMENTS.join(", ")}. That takes about 90 MB. Nothing else is changed.`,
  ].join("\n\n");
  const answer = await window.showInformationMessage("Install Improv's language server?", { modal: true, detail }, "Install");
  if (answer !== "Install") return false;

  const title = "Improv: installing its language server…";
  return window.withProgress({ location: ProgressLocation.Notification, title, cancellable: true }, async (_, token) => {
    const stop = new AbortController();
    token.onCancellationRequested(() => stop.abort());
    const step = async (program: string, ...args: string[]): Promise<void> => {
      log.info([program, ...args].join(" "));
      const { stdout, stderr } = await run(program, args, { cwd: context.globalStorageUri.fsPath, signal: stop.signal });
      log.info(stdout + stderr);
    };
    try {
      await mkdir(context.globalStorageUri.fsPath, { recursive: true });
      await step(python, "-m", "venv", "--clear", environment);
      const inside = join(ownServer(context), "..", process.platform === "win32" ? "python.exe" : "python");
      const pip = ["-m", "pip", "install", "--disable-pip-version-check"];
      await step(inside, ...pip, await wheel(context));
      await forgetOthers(context);
      return true;
    } catch (error) {
      await rm(environment, { recursive: true, force: true });
      if (token.isCancellationRequested) return false;
      log.error(error as Error);
      const logs = "Show logs";
      void window
        .showErrorMessage("Improv's language server can't be installed: the logs say why.", logs)
        .then((choice) => choice === logs && log.show());
      return false;
    }
  });
}

/** The first Python that is new enough and can make environments. */
async function findPython(): Promise<string | undefined> {
  const selected = await selectedPython();
  for (const python of [...(selected ? [selected] : []), ...onPath("python3"), ...onPath("python")]) {
    const fits = await run(python, ["-c", FITS]).then(
      () => true,
      () => false,
    );
    if (fits) return python;
  }
  return undefined;
}

async function wheel(context: ExtensionContext): Promise<string> {
  const folder = context.asAbsolutePath("wheel");
  const name = (await readdir(folder)).find((each) => each.endsWith(".whl"));
  if (!name) throw new Error(`There is no wheel in ${folder}: build the extension with "npm run package".`);
  return join(folder, name);
}

/** Removes what earlier versions of the extension have installed. */
async function forgetOthers(context: ExtensionContext): Promise<void> {
  const storage = context.globalStorageUri.fsPath;
  const own = basename(ownEnvironment(context));
  for (const name of await readdir(storage)) {
    if (name.startsWith("server-") && name !== own) await rm(join(storage, name), { recursive: true, force: true });
  }
}
