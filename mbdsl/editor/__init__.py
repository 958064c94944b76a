"""Support of editors: highlighting, and the language server `mbdsl lsp`."""
