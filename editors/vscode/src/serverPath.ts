// Finds the language server. Never runs anything from an untrusted workspace.

import { existsSync } from "node:fs";
import { delimiter, dirname, isAbsolute, join, sep } from "node:path";
import { Disposable, ExtensionContext, extensions, Uri, workspace } from "vscode";

const WINDOWS = process.platform === "win32";

/** The server's path: from the setting, or the first one found; undefined if there is none. */
export async function findServer(context: ExtensionContext): Promise<string | undefined> {
  const set = workspace.getConfiguration("improv").get<string>("server.path");
  if (set) return isAbsolute(set) ? set : onPath(set)[0];
  const name = WINDOWS ? "improv-ls.exe" : "improv-ls";
  const python = await selectedPython();
  const beside = python ? [join(dirname(python), name)] : [];
  return [...onPath("improv-ls"), ...beside, ownServer(context)].find(isRunnable);
}

/** Where the server is, or would be, in the extension's own environment. Each version of the extension has one. */
export function ownServer(context: ExtensionContext): string {
  return join(ownEnvironment(context), WINDOWS ? "Scripts\\improv-ls.exe" : "bin/improv-ls");
}

export function ownEnvironment(context: ExtensionContext): string {
  const { version } = context.extension.packageJSON as { version: string };
  return join(context.globalStorageUri.fsPath, `server-${version}`);
}

/** The programs with a name on the PATH. */
export function onPath(name: string): string[] {
  const file = WINDOWS && !name.endsWith(".exe") ? `${name}.exe` : name;
  const folders = (process.env["PATH"] ?? "").split(delimiter).filter(isAbsolute); // relative ones lead into the workspace
  return folders.map((folder) => join(folder, file)).filter(isRunnable);
}

/** The Python that is selected in the Python extension, if that extension is installed and works. */
export async function selectedPython(): Promise<string | undefined> {
  const environments = await pythonEnvironments();
  const folder = workspace.workspaceFolders?.[0]?.uri;
  const path = environments?.getActiveEnvironmentPath(folder);
  const resolved = path && (await environments?.resolveEnvironment(path).catch(() => undefined));
  const python = resolved?.executable.uri?.fsPath;
  return python && isRunnable(python) ? python : undefined;
}

/** Calls back when a different Python is selected in the Python extension. */
export async function onSelectedPython(callback: () => void): Promise<Disposable | undefined> {
  return (await pythonEnvironments())?.onDidChangeActiveEnvironmentPath(callback);
}

/** The part of the Python extension's public API that we use. */
interface Environments {
  getActiveEnvironmentPath(resource?: Uri): { path: string };
  resolveEnvironment(path: { path: string }): Promise<{ executable: { uri?: Uri } } | undefined>;
  onDidChangeActiveEnvironmentPath(callback: () => void): Disposable;
}

async function pythonEnvironments(): Promise<Environments | undefined> {
  const python = extensions.getExtension<{ environments?: Environments } | undefined>("ms-python.python");
  try {
    return (await python?.activate())?.environments;
  } catch {
    return undefined; // it reports its own problems
  }
}

/** Whether the file exists and does not belong to an untrusted workspace. */
function isRunnable(path: string): boolean {
  const folders = workspace.isTrusted ? [] : (workspace.workspaceFolders ?? []);
  return existsSync(path) && !folders.some(({ uri }) => path.startsWith(uri.fsPath + sep));
}
