// Stands in for VS Code: runs the extension of a folder with a server, and says what it gave.

const Module = require("module");
const path = require("path");

const [folder, command] = [process.argv[2], JSON.parse(process.argv[3])];
const TEXT = 'model board\n  "It."\n  face top\n  top is levle, tilt(top) at most 5 deg\n';

const providers = {};
const errors = [];
const nothing = { dispose() {} };
const listen = () => nothing;
const event = () => nothing;
const plain = (...names) =>
  class {
    constructor(...values) {
      names.forEach((name, i) => (this[name] = values[i]));
    }
  };
const document = {
  uri: { toString: () => "file:///nowhere/board.model" },
  languageId: "facetlog-model",
  version: 1,
  getText: () => TEXT,
};

let told;
const faults = new Promise((resolve) => (told = resolve));

const vscode = {
  Position: plain("line", "character"),
  Range: plain("start", "end"),
  Location: plain("uri", "range"),
  TextEdit: plain("range", "newText"),
  MarkdownString: plain("value"),
  Diagnostic: plain("range", "message", "severity"),
  DiagnosticRelatedInformation: plain("location", "message"),
  Hover: plain("contents", "range"),
  CompletionItem: plain("label", "kind"),
  CodeAction: plain("title", "kind"),
  CodeActionKind: { Empty: { append: (value) => ({ value }) } },
  DocumentSymbol: plain("name", "detail", "kind", "range", "selectionRange"),
  WorkspaceEdit: class {
    set() {}
  },
  Uri: { parse: (text) => text },
  commands: { registerCommand: () => nothing },
  window: { showErrorMessage: (message) => errors.push(message) },
  workspace: {
    textDocuments: [document],
    getConfiguration: () => ({ get: () => command }),
    createFileSystemWatcher: () => ({ ...nothing, onDidCreate: event, onDidChange: event, onDidDelete: event }),
    onDidOpenTextDocument: listen,
    onDidChangeTextDocument: listen,
    onDidCloseTextDocument: listen,
    onDidChangeConfiguration: listen,
  },
  languages: new Proxy(
    { createDiagnosticCollection: () => ({ ...nothing, set: (_, found) => told(found), delete() {} }) },
    {
      get: (own, name) =>
        own[name] ?? ((_, provider) => (Object.assign(providers, provider), nothing)),
    },
  ),
};

const load = Module._load;
Module._load = (name, ...more) => (name === "vscode" ? vscode : load(name, ...more));

(async () => {
  const extension = require(path.join(folder, "extension.js"));
  await extension.activate({ subscriptions: [] });
  const found = await faults;
  const place = { line: 3, character: 11 };
  if (errors.length) console.error(errors);
  const actions = await providers.provideCodeActions(document, { start: place, end: place }, {});
  const said = {
    faults: found.filter((one) => one.severity === 0).map((one) => one.code),
    actions: actions.map((one) => one.title),
    completions: (await providers.provideCompletionItems(document, { line: 3, character: 9 })).map((one) => one.label),
    hover: (await providers.provideHover(document, { line: 3, character: 17 })).contents.value,
    symbols: (await providers.provideDocumentSymbols(document)).map((one) => one.name),
    errors,
  };
  await extension.deactivate();
  console.log(JSON.stringify(said));
})();
