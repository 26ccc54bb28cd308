// Installs the language server into the extension's own storage, after showing what that brings.

import { execFile } from "node:child_process";
import { mkdir, readdir, rm } from "node:fs/promises";
import { homedir } from "node:os";
import { basename, join } from "node:path";
import { promisify } from "node:util";
import { ExtensionContext, LogOutputChannel, ProgressLocation, window } from "vscode";
import { confirm, showError } from "./messages";
import { onPath, ownEnvironment, ownServer, selectedPython } from "./serverPath";

declare const REQUIREMENTS: string[]; // from pyproject.toml; build.mjs fills it in

const run = promisify(execFile);
const ISOLATED = "-I"; // imports nothing from the workspace, whatever PYTHONPATH says
const IS_SUITABLE = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";

/** Installs the server if the person agrees, and reports problems. True if it is installed. */
export async function install(context: ExtensionContext, log: LogOutputChannel): Promise<boolean> {
  const python = await findPython();
  if (!python) {
    const packages = process.platform === "linux" ? " (on Debian and Ubuntu, also the package python3-venv)" : "";
    void showError(`Improv needs Python 3.11 or newer. Install it${packages}, then try again.`);
    return false;
  }
  const environment = ownEnvironment(context);
  const detail = [
    `This creates a Python environment with ${python} in`,
    environment,
    `It contains Improv ${context.extension.packageJSON.version}, which comes with this extension, and the packages that ` +
      `it needs, which pip downloads: ${REQUIREMENTS.join(", ")}. It takes about 90 MB. Nothing else on your computer changes.`,
  ].join("\n\n");
  if (!(await confirm("Install Improv's language server?", detail, "Install"))) return false;

  const title = "Installing Improv's language server…";
  return window.withProgress({ location: ProgressLocation.Notification, title, cancellable: true }, async (_, token) => {
    const stop = new AbortController();
    token.onCancellationRequested(() => stop.abort());
    const cwd = context.globalStorageUri.fsPath;
    const step = async (program: string, ...args: string[]): Promise<void> => {
      const isolated = [ISOLATED, ...args];
      log.info([program, ...isolated].join(" "));
      const { stdout, stderr } = await run(program, isolated, { cwd, signal: stop.signal });
      log.info(stdout + stderr);
    };
    try {
      await mkdir(cwd, { recursive: true });
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
      const problem = "Improv's language server could not be installed. The logs say why.";
      void showError(problem, "Show Logs").then((choice) => choice && log.show());
      return false;
    }
  });
}

/** The first Python that is new enough and can create environments. */
async function findPython(): Promise<string | undefined> {
  const selected = await selectedPython();
  for (const python of [...(selected ? [selected] : []), ...onPath("python3"), ...onPath("python")]) {
    const isSuitable = await run(python, [ISOLATED, "-c", IS_SUITABLE], { cwd: homedir() }).then(
      () => true,
      () => false,
    );
    if (isSuitable) return python;
  }
  return undefined;
}

async function wheel(context: ExtensionContext): Promise<string> {
  const folder = context.asAbsolutePath("wheel");
  const name = (await readdir(folder)).find((each) => each.endsWith(".whl"));
  if (!name) throw new Error(`${folder} contains no wheel: build the extension with "npm run package".`);
  return join(folder, name);
}

/** Removes what earlier versions of the extension installed. */
async function forgetOthers(context: ExtensionContext): Promise<void> {
  const storage = context.globalStorageUri.fsPath;
  const own = basename(ownEnvironment(context));
  for (const name of await readdir(storage)) {
    if (name.startsWith("server-") && name !== own) await rm(join(storage, name), { recursive: true, force: true });
  }
}
