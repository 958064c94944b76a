"""The language server `mbdsl lsp`: the Language Server Protocol by pygls, over standard input and output."""

from __future__ import annotations

import asyncio
import logging
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any, BinaryIO, cast

from lsprotocol import types as lsp
from pygls import uris
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer

from mbdsl.editor import navigation
from mbdsl.editor.check_process import CheckProcess
from mbdsl.editor.completion import Proposal, complete
from mbdsl.editor.connection import MessageInput
from mbdsl.editor.hover import hover
from mbdsl.editor.navigation import Location
from mbdsl.editor.positions import Places
from mbdsl.editor.workspace import OpenFiles
from mbdsl.errors import MbdslError, Span, UsageError
from mbdsl.lang.library import Allowed, key_of
from mbdsl.version import __version__

PAUSE = 0.25  #: [s] without changes before a text is checked
LIMIT = 20.0  #: [s] of a check
REFUSED = -32803  #: code of a request that is valid, but cannot be done

_FORMS = {
    "kind": lsp.CompletionItemKind.Class,
    "model": lsp.CompletionItemKind.Class,
    "type": lsp.CompletionItemKind.TypeParameter,
    "parameter": lsp.CompletionItemKind.Property,
    "signal": lsp.CompletionItemKind.Field,
    "frame": lsp.CompletionItemKind.Reference,
    "component": lsp.CompletionItemKind.Variable,
    "value": lsp.CompletionItemKind.Constant,
    "unit": lsp.CompletionItemKind.Unit,
    "keyword": lsp.CompletionItemKind.Keyword,
    "function": lsp.CompletionItemKind.Function,
    "choice": lsp.CompletionItemKind.EnumMember,
}


class Server(LanguageServer):
    """The server of one editor.

    Parameters
    ----------
    allowed : bool or path, optional
        Folders that imports may lead to, as for ``mbdsl.load``.
    """

    def __init__(self, allowed: Allowed | None = None) -> None:
        # The whole text is sent after each change: models are short, and pygls cuts lines at other characters.
        super().__init__("mbdsl", __version__, text_document_sync_kind=lsp.TextDocumentSyncKind.Full)
        self.allowed = allowed
        self.models = OpenFiles(allowed)
        self.ended = False  #: whether the editor has ended the session
        self.uris: dict[str, str] = {}  #: path -> URI, of open files
        self.values: dict[str, tuple[str, str, dict[str, str]]] = {}  #: path -> text, its main model and values
        self._checks: dict[str, asyncio.Task] = {}
        self._checker = CheckProcess()

    # -- places ------------------------------------------------------------------------------------------------

    def path(self, uri: str) -> str:
        """The path of a document; a document that was never saved has its URI."""
        return uris.to_fs_path(uri) or uri

    def places(self, path: str) -> Places:
        """Conversions for a file."""
        encoding = self.workspace.position_encoding or lsp.PositionEncodingKind.Utf16
        return Places(self.models.text(path), getattr(encoding, "value", encoding))

    def offset(self, params: Any) -> tuple[str, int]:
        """Path and offset of a request."""
        path = self.path(params.text_document.uri)
        return path, self.places(path).offset(params.position.line, params.position.character)

    def range(self, path: str, start: int, end: int) -> lsp.Range:
        """A range in a file."""
        places = self.places(path)
        first, last = places.position(start), places.position(end)
        return lsp.Range(lsp.Position(*first), lsp.Position(*last))

    def location(self, at: Location) -> lsp.Location:
        """A place in any file."""
        return lsp.Location(self.uri(at.path), self.range(*at))

    def uri(self, path: str) -> str:
        """The URI of a file; that of the editor, if it is open."""
        known = next((uri for name, uri in self.uris.items() if key_of(name) == key_of(path)), None)
        return known or uris.from_fs_path(os.path.abspath(path)) or path

    # -- checks ------------------------------------------------------------------------------------------------

    def changed(self, uri: str) -> None:
        """Take over the text of a document; check it, and the open files that import it, after a pause."""
        path = self.path(uri)
        self.uris[path] = uri
        self.models.open(path, self.workspace.get_text_document(uri).source)
        for other in list(self.uris):
            if other == path or self._imports(other, path):
                self.schedule(other)

    def closed(self, uri: str) -> None:
        """Forget a document."""
        path = self.path(uri)
        self.models.close(path)
        self.values.pop(path, None)
        if self.uris.pop(path, None) is not None:
            self._cancel(path)
            self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    def schedule(self, path: str) -> None:
        """Check a file after a pause, instead of the check that runs."""
        self._cancel(path)
        self._checks[path] = asyncio.get_running_loop().create_task(self._check(path))

    def _cancel(self, path: str) -> None:
        if (running := self._checks.pop(path, None)) is not None:
            running.cancel()

    def _imports(self, path: str, other: str) -> bool:
        if os.path.basename(key_of(other)) not in os.path.normcase(self.models.texts[path]):
            return False  # most of many open files: their names are not read for this
        with suppress(MbdslError, RecursionError):
            unit = self.models.names(path).unit
            files = [u.file.name for u in (*unit.imports, *unit.aliases.values())]
            missing = [os.path.join(os.path.dirname(path), item.path) for item in unit.file.imports]
            return key_of(other) in map(key_of, (*files, *missing))
        return False

    async def _check(self, path: str) -> None:
        await asyncio.sleep(PAUSE)
        text = self.models.texts[path]
        request = {"text": text, "file": path, "texts": self.models.texts, "allowed": self.allowed}
        answer = await self._checker.check(request, LIMIT)
        if self.models.texts.get(path) != text:
            return
        self.values[path] = (text, answer["model"], answer["values"])
        found = [self._diagnostic(path, problem) for problem in answer["problems"]]
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(self.uris[path], found))

    def _diagnostic(self, path: str, problem: dict[str, Any]) -> lsp.Diagnostic:
        related = []
        span = problem["span"]
        text = "\n".join(filter(None, (problem["message"], problem["hint"])))
        places = [(note, at) for note, at in problem["notes"] if at is not None]
        if span is not None and key_of(span[0]) != key_of(path):
            places.insert(0, (problem["message"], span))
            text, span = f"{os.path.basename(span[0])}, line {span[1]}: {text}", None
        for note, at in places:
            with suppress(UsageError):
                where = lsp.Location(self.uri(at[0]), self._of_span(at[0], at))
                related.append(lsp.DiagnosticRelatedInformation(where, note))
        severity = lsp.DiagnosticSeverity.Warning if problem["severity"] == "warning" else lsp.DiagnosticSeverity.Error
        at = self._of_span(path, span) if span is not None else self._beginning(path)
        return lsp.Diagnostic(at, text, severity, source="mbdsl", related_information=related or None)

    def _of_span(self, path: str, span: list) -> lsp.Range:
        return self.range(path, *self.places(path).of_span(Span(*span)))

    def _beginning(self, path: str) -> lsp.Range:
        """For an error of another file: the first import; for one without a place: the name of the last model."""
        file = self.models.names(path).unit.file
        at = next((x.at for x in (*file.imports, *reversed(file.models)) if x.at is not None), None)
        return self.range(path, at[1], at[2]) if at is not None else self.range(path, 0, 1)


#: feature of the protocol -> the function that answers it, and the options of the feature
FEATURES: dict[str, tuple[Callable, Any]] = {}


def _answers(feature: str, options: Any = None) -> Callable[[Callable], Callable]:
    """Decorate a function of a server and the parameters of a request, which answers a feature."""

    def note(function: Callable) -> Callable:
        FEATURES[feature] = function, options
        return function

    return note


@_answers(lsp.INITIALIZED)
def initialized(ls: Server, params: lsp.InitializedParams) -> None:
    found = [ls.workspace.root_path, *(uris.to_fs_path(uri) for uri in ls.workspace.folders)]
    ls.models.folders = list(dict.fromkeys(path for path in found if path))


@_answers(lsp.SHUTDOWN)
def shutdown(ls: Server, params: None) -> None:
    ls.ended = True


@_answers(lsp.TEXT_DOCUMENT_DID_OPEN)
@_answers(lsp.TEXT_DOCUMENT_DID_CHANGE)
@_answers(lsp.TEXT_DOCUMENT_DID_SAVE)
async def changed(ls: Server, params: Any) -> None:
    ls.changed(params.text_document.uri)


@_answers(lsp.TEXT_DOCUMENT_DID_CLOSE)
async def closed(ls: Server, params: lsp.DidCloseTextDocumentParams) -> None:
    ls.closed(params.text_document.uri)


@_answers(lsp.TEXT_DOCUMENT_COMPLETION, lsp.CompletionOptions(trigger_characters=[".", "("]))
def completion(ls: Server, params: lsp.CompletionParams) -> lsp.CompletionList:
    path, offset = ls.offset(params)
    start, found = complete(ls.models.names(path).unit, offset)
    at = ls.range(path, start, offset)
    return lsp.CompletionList(False, [_completion_item(item, at) for item in found])


@_answers(lsp.TEXT_DOCUMENT_HOVER)
def on_hover(ls: Server, params: lsp.HoverParams) -> lsp.Hover | None:
    path, offset = ls.offset(params)
    text, main, values = ls.values.get(path, ("", "", {}))
    known = values if text == ls.models.text(path) else {}
    found = hover(ls.models.names(path), offset, known, main)
    if found is None:
        return None
    content = lsp.MarkupContent(lsp.MarkupKind.Markdown, found.text)
    return lsp.Hover(content, ls.range(path, found.start, found.end))


@_answers(lsp.TEXT_DOCUMENT_DEFINITION)
def definition(ls: Server, params: lsp.DefinitionParams) -> list[lsp.Location]:
    return [ls.location(at) for at in navigation.definition(ls.models, *ls.offset(params))]


@_answers(lsp.TEXT_DOCUMENT_REFERENCES)
def references(ls: Server, params: lsp.ReferenceParams) -> list[lsp.Location]:
    declared = params.context.include_declaration
    return [ls.location(at) for at in navigation.references(ls.models, *ls.offset(params), declared)]


@_answers(lsp.TEXT_DOCUMENT_PREPARE_RENAME)
def prepare_rename(ls: Server, params: lsp.PrepareRenameParams) -> lsp.PrepareRenamePlaceholder:
    path, offset = ls.offset(params)
    found = _refusing(navigation.renamable, ls.models, path, offset)
    return lsp.PrepareRenamePlaceholder(ls.range(path, found.start, found.end), found.symbol.name)


@_answers(lsp.TEXT_DOCUMENT_RENAME, lsp.RenameOptions(prepare_provider=True))
def rename(ls: Server, params: lsp.RenameParams) -> lsp.WorkspaceEdit:
    path, offset = ls.offset(params)
    changes: dict[str, list[lsp.TextEdit]] = {}
    for at in _refusing(navigation.rename, ls.models, path, offset, params.new_name):
        changes.setdefault(ls.uri(at.path), []).append(lsp.TextEdit(ls.range(*at), params.new_name))
    return lsp.WorkspaceEdit(changes)


def make_server(allowed: Allowed | None = None) -> Server:
    """The server with all features.

    Parameters
    ----------
    allowed : bool or path, optional
        Folders that imports may lead to, as for ``mbdsl.load``.
    """
    server = Server(allowed)
    for feature, (function, options) in FEATURES.items():
        server.feature(feature, options)(function)
    return server


def serve(allowed: Allowed | None = None) -> bool:
    """Run the server over standard input and output until the editor ends it.

    Parameters
    ----------
    allowed : bool or path, optional
        Folders that imports may lead to, as for ``mbdsl.load``.

    Returns
    -------
    bool
        Whether the editor has ended the session, as the protocol requires, before it closed the connection.
    """
    # pygls writes tracebacks of requests that are refused, although the editor shows their messages.
    logging.getLogger("pygls.protocol.json_rpc").addFilter(_is_unexpected)
    logging.getLogger("pygls.server").addFilter(_without_traceback)
    server, messages = make_server(allowed), MessageInput(sys.stdin.buffer)
    # pygls closes its streams; those of the process remain open for the command line.
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as stdout:
        server.start_io(cast(BinaryIO, messages), stdout)  # it reads and reads lines
    if messages.problem:
        print(f"the language server has ended: {messages.problem}", file=sys.stderr)
    return server.ended


def _is_unexpected(record: logging.LogRecord) -> bool:
    return not (record.exc_info and isinstance(record.exc_info[1], JsonRpcException))


def _without_traceback(record: logging.LogRecord) -> bool:
    """Messages that are not JSON, or not of the protocol, are named in a line."""
    if record.exc_info:
        record.msg, record.args, record.exc_info = "%s: %s", (record.getMessage(), record.exc_info[1]), None
    return True


def _completion_item(item: Proposal, at: lsp.Range) -> lsp.CompletionItem:
    return lsp.CompletionItem(
        item.label,
        kind=_FORMS[item.form],
        detail=item.detail or None,
        documentation=lsp.MarkupContent(lsp.MarkupKind.Markdown, item.doc) if item.doc else None,
        sort_text=f"{item.rank}{item.label}",
        filter_text=item.label,
        text_edit=lsp.TextEdit(at, item.label),
    )


def _refusing(action: Any, *args: Any) -> Any:
    """The result of an action; the user sees the message of an error, without a traceback."""
    try:
        return action(*args)
    except MbdslError as problem:
        message = "; ".join(filter(None, (problem.message, problem.hint)))
        raise JsonRpcException(message, REFUSED) from None
