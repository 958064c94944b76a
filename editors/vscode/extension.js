// Starts the language server `mbdsl lsp`. Highlighting works without it. The client of the protocol is the package
// vscode-languageclient of Microsoft, which `npm install` in this folder downloads; there is no build step.
"use strict";
const vscode = require("vscode");

let client;

async function activate() {
  let library;
  try {
    library = require("vscode-languageclient/node");
  } catch {
    vscode.window.showInformationMessage(
      `mbdsl: models are highlighted. For error messages and completion, run "npm install" in ${__dirname} and reload.`
    );
    return;
  }
  const [command, ...args] = vscode.workspace.getConfiguration("mbdsl").get("command");
  client = new library.LanguageClient(
    "mbdsl",
    "mbdsl",
    { command, args, transport: library.TransportKind.stdio },
    { documentSelector: [{ language: "mbd" }] }
  );
  try {
    await client.start();
  } catch (problem) {
    vscode.window.showErrorMessage(
      `mbdsl: cannot start "${[command, ...args].join(" ")}": ${problem.message}. ` +
        `Install mbdsl with the extra "editor", and set "mbdsl.command" to the path of mbdsl if it is not on PATH.`
    );
  }
}

function deactivate() {
  return client && client.stop();
}

module.exports = { activate, deactivate };
