// Starts the language server of facetlog for model files, and again on request.

const { commands, window, workspace } = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

let client;

async function start() {
  const [command, ...args] = workspace.getConfiguration("facetlog").get("command");
  client = new LanguageClient(
    "facetlog-model",
    "facetlog models",
    { command, args, transport: TransportKind.stdio },
    {
      documentSelector: [{ language: "facetlog-model" }],
      // Files that a model uses may change outside of the editor.
      synchronize: { fileEvents: workspace.createFileSystemWatcher("**/*.{model,pl}") },
    },
  );
  try {
    await client.start();
  } catch (error) {
    window.showErrorMessage(
      `facetlog: \`${[command, ...args].join(" ")}\` cannot be started (${error.message}); ` +
        "set facetlog.command to where facetlog is installed.",
    );
  }
}

async function stop() {
  const running = client;
  client = undefined;
  if (running !== undefined && running.needsStop()) {
    await running.stop();
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
