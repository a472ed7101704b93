// Starts the language server of facetlog for model files, and again on request.

const { commands, languages, window, workspace } = require("vscode");
const { Connection } = require("./connection");
const { diagnostics, register } = require("./providers");

const LANGUAGE = "facetlog-model";

let running;

function said(command, message) {
  window.showErrorMessage(
    `facetlog: \`${command.join(" ")}\` cannot be started (${message}); ` +
      "set facetlog.command to where facetlog is installed.",
  );
}

async function start() {
  const command = workspace.getConfiguration("facetlog").get("command");
  const faults = languages.createDiagnosticCollection(LANGUAGE);
  const held = [faults];
  const connection = new Connection(
    command,
    (method, params) => {
      if (method === "textDocument/publishDiagnostics") {
        const document = workspace.textDocuments.find((one) => one.uri.toString() === params.uri);
        if (document !== undefined) {
          faults.set(document.uri, diagnostics(params.diagnostics));
        }
      }
    },
    (reason) => {
      said(command, reason);
      held.forEach((one) => one.dispose());
    },
  );
  running = { connection, held };
  const folders = (workspace.workspaceFolders ?? []).map((one) => ({
    uri: one.uri.toString(),
    name: one.name,
  }));
  try {
    const { capabilities } = await connection.request("initialize", {
      processId: process.pid,
      rootUri: folders[0]?.uri ?? null,
      workspaceFolders: folders,
      capabilities: {
        textDocument: { documentSymbol: { hierarchicalDocumentSymbolSupport: true } },
        workspace: { workspaceFolders: true },
      },
    });
    connection.notify("initialized", {});
    synchronise(connection, faults, held);
    held.push(...register(connection, capabilities, { language: LANGUAGE }));
  } catch (error) {
    if (!connection.over) {
      said(command, error.message); // else its end was told
    }
  }
}

// Tells the server of the texts that are open, and of files that change outside of the editor.
function synchronise(connection, faults, held) {
  const ours = (document) => document.languageId === LANGUAGE;
  const named = (document) => ({ uri: document.uri.toString(), version: document.version });
  const opened = (document) => {
    if (ours(document)) {
      const textDocument = { ...named(document), languageId: LANGUAGE, text: document.getText() };
      connection.notify("textDocument/didOpen", { textDocument });
    }
  };
  const watcher = workspace.createFileSystemWatcher("**/*.{model,pl}");
  const changed = (type) => (file) => {
    const changes = [{ uri: file.toString(), type }];
    connection.notify("workspace/didChangeWatchedFiles", { changes });
  };
  held.push(
    workspace.onDidOpenTextDocument(opened),
    workspace.onDidChangeTextDocument(({ document, contentChanges }) => {
      if (ours(document)) {
        connection.notify("textDocument/didChange", {
          textDocument: named(document),
          contentChanges: contentChanges.map(({ range, text }) => ({ range, text })),
        });
      }
    }),
    workspace.onDidCloseTextDocument((document) => {
      if (ours(document)) {
        connection.notify("textDocument/didClose", { textDocument: named(document) });
        faults.delete(document.uri);
      }
    }),
    watcher,
    watcher.onDidCreate(changed(1)),
    watcher.onDidChange(changed(2)),
    watcher.onDidDelete(changed(3)),
  );
  workspace.textDocuments.forEach(opened);
}

async function stop() {
  const before = running;
  running = undefined;
  if (before !== undefined) {
    before.held.forEach((one) => one.dispose());
    await before.connection.close();
  }
}

async function restart() {
  await stop();
  await start();
}

function activate(context) {
  context.subscriptions.push(
    commands.registerCommand("facetlog.restart", restart),
    workspace.onDidChangeConfiguration((event) => {
      if (event.affectsConfiguration("facetlog.command")) {
        return restart();
      }
    }),
  );
  return start();
}

module.exports = { activate, deactivate: stop };
