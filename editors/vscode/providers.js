// What VS Code asks of a model file, handed to the server, and its answers in VS Code's own types.

const vscode = require("vscode");

const position = (at) => new vscode.Position(at.line, at.character);
const range = (of) => new vscode.Range(position(of.start), position(of.end));
const uri = (document) => ({ uri: document.uri.toString() });
const markdown = (text) => text && new vscode.MarkdownString(text.value ?? text);
const textEdits = (edits) => (edits ?? []).map((one) => new vscode.TextEdit(range(one.range), one.newText));
const location = (at) => at && new vscode.Location(vscode.Uri.parse(at.uri), range(at.range));

function diagnostics(found) {
  return found.map((one) => {
    const shown = new vscode.Diagnostic(range(one.range), one.message, one.severity - 1);
    shown.code = one.code;
    shown.source = one.source;
    shown.relatedInformation = one.relatedInformation?.map(
      (other) => new vscode.DiagnosticRelatedInformation(location(other.location), other.message),
    );
    return shown;
  });
}

function workspaceEdit(edit) {
  const found = new vscode.WorkspaceEdit();
  for (const [file, edits] of Object.entries(edit?.changes ?? {})) {
    found.set(vscode.Uri.parse(file), textEdits(edits));
  }
  return found;
}

function symbol(one) {
  const found = new vscode.DocumentSymbol(
    one.name, one.detail ?? "", one.kind - 1, range(one.range), range(one.selectionRange),
  );
  found.children = (one.children ?? []).map(symbol);
  return found;
}

function completion(one) {
  const found = new vscode.CompletionItem(one.label, one.kind - 1);
  found.detail = one.detail;
  found.documentation = markdown(one.documentation);
  return found;
}

function action(one) {
  const found = new vscode.CodeAction(one.title, vscode.CodeActionKind.Empty.append(one.kind));
  found.edit = workspaceEdit(one.edit);
  found.isPreferred = one.isPreferred;
  found.diagnostics = one.diagnostics && diagnostics(one.diagnostics);
  return found;
}

// Registers all that the server can; returns what takes it back.
function register(connection, can, selector) {
  const { languages } = vscode;
  const ask = (method, document, more, token) =>
    connection.request(`textDocument/${method}`, { textDocument: uri(document), ...more }, token);
  const at = (method, document, place, token, more) =>
    ask(method, document, { position: { line: place.line, character: place.character }, ...more }, token);
  return [
    languages.registerCompletionItemProvider(selector, {
      provideCompletionItems: async (document, place, token) =>
        (await at("completion", document, place, token)).items.map(completion),
    }, ...can.completionProvider.triggerCharacters),
    languages.registerHoverProvider(selector, {
      provideHover: async (document, place, token) => {
        const found = await at("hover", document, place, token);
        return found && new vscode.Hover(markdown(found.contents), range(found.range));
      },
    }),
    languages.registerDefinitionProvider(selector, {
      provideDefinition: async (document, place, token) =>
        location(await at("definition", document, place, token)),
    }),
    languages.registerReferenceProvider(selector, {
      provideReferences: async (document, place, context, token) => {
        const more = { context: { includeDeclaration: context.includeDeclaration } };
        return (await at("references", document, place, token, more)).map(location);
      },
    }),
    languages.registerRenameProvider(selector, {
      prepareRename: async (document, place, token) =>
        range(await at("prepareRename", document, place, token)),
      provideRenameEdits: async (document, place, newName, token) =>
        workspaceEdit(await at("rename", document, place, token, { newName })),
    }),
    languages.registerDocumentSymbolProvider(selector, {
      provideDocumentSymbols: async (document, token) =>
        (await ask("documentSymbol", document, {}, token)).map(symbol),
    }),
    languages.registerDocumentFormattingEditProvider(selector, {
      provideDocumentFormattingEdits: async (document, options, token) =>
        textEdits(await ask("formatting", document, { options }, token)),
    }),
    languages.registerCodeActionsProvider(selector, {
      provideCodeActions: async (document, where, context, token) => {
        const only = context.only && { only: [context.only.value] };
        const more = { range: where, context: { diagnostics: [], ...only } };
        return (await ask("codeAction", document, more, token)).map(action);
      },
    }),
  ];
}

module.exports = { diagnostics, register };
