"""A client of the Language Server Protocol: it starts `mbdsl lsp` and speaks JSON-RPC with it."""

import json
import subprocess
import sys
import threading
from queue import Queue

import pytest

WAIT = 300.0  #: [s] for an answer; only a server that hangs takes so long


class Client:
    """One session; positions are given by a mark ``|`` in the text, or by a word."""

    def __init__(self, folder, *options, encodings=None):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "mbdsl", "lsp", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.folder, self.count, self.version = folder, 0, 0
        self.answers, self.diagnostics, self.texts = {}, Queue(), {}
        self.answered = threading.Condition()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        capabilities = {"general": {"positionEncodings": encodings} if encodings else {}}
        capabilities["textDocument"] = {"rename": {"prepareSupport": True}}
        self.capabilities = self.ask(
            "initialize",
            {"processId": None, "rootUri": folder.as_uri(), "capabilities": capabilities},
        )["capabilities"]
        self.tell("initialized", {})

    def _read(self):
        stream = self.process.stdout
        while line := stream.readline():
            length = int(line.split(b":")[1])
            while stream.readline().strip():
                pass
            message = json.loads(stream.read(length))
            if "id" in message and "method" not in message:
                with self.answered:
                    self.answers[message["id"]] = message
                    self.answered.notify_all()
            elif message.get("method") == "textDocument/publishDiagnostics":
                self.diagnostics.put(message["params"])

    def _send(self, message):
        content = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(content) + content)
        self.process.stdin.flush()

    def tell(self, method, params):
        self._send({"method": method, "params": params})

    def ask(self, method, params, error=False):
        """The result of a request, or its error."""
        self.count += 1
        number = self.count
        self._send({"id": number, "method": method, "params": params})
        with self.answered:
            assert self.answered.wait_for(lambda: number in self.answers, WAIT), f"no answer to {method}"
        answer = self.answers[number]
        assert ("error" in answer) == error, answer
        return answer["error"] if error else answer["result"]

    # -- documents ---------------------------------------------------------------------------------------------
    def uri(self, name):
        return (self.folder / name).as_uri()

    def show(self, name, text):
        """Open a document, or change its text."""
        self.version += 1
        known, self.texts[name] = name in self.texts, text
        if known:
            document = {"uri": self.uri(name), "version": self.version}
            self.tell("textDocument/didChange", {"textDocument": document, "contentChanges": [{"text": text}]})
        else:
            document = {"uri": self.uri(name), "languageId": "mbd", "version": self.version, "text": text}
            self.tell("textDocument/didOpen", {"textDocument": document})

    def problems(self, name):
        """The next diagnostics of a document."""
        while True:
            found = self.diagnostics.get(timeout=WAIT)
            if found["uri"] == self.uri(name):
                return found["diagnostics"]

    def at(self, name, word, number=0):
        """Parameters of a request about a word: the middle of its occurrence ``number``."""
        text, at = self.texts[name], -1
        for _ in range(number + 1):
            at = text.index(word, at + 1)
        return self.place(name, at + len(word) // 2)

    def place(self, name, offset):
        """Parameters of a request about an offset."""
        before = self.texts[name][:offset].split("\n")
        column = len(before[-1].encode("utf-16-le", "surrogatepass")) // 2
        position = {"line": len(before) - 1, "character": column}
        return {"textDocument": {"uri": self.uri(name)}, "position": position}

    def complete(self, name, text):
        """Labels of the proposals at the mark ``|``, in their order."""
        offset = text.index("|")
        self.show(name, text.replace("|", "", 1))
        items = self.ask("textDocument/completion", self.place(name, offset))["items"]
        return [item["label"] for item in sorted(items, key=lambda item: item["sortText"])]

    def text_of(self, location):
        """The text of a location or an edit in an open document."""
        name = location["uri"].rpartition("/")[2]
        return cut(self.texts[name], location["range"])

    def close(self):
        """End the session; return the exit code of the server and what it wrote to standard error."""
        self.ask("shutdown", None)
        self.tell("exit", None)
        return self.ended()

    def ended(self):
        """The exit code of the server and what it wrote to standard error, after its input was closed."""
        self.process.stdin.close()
        errors = self.process.stderr.read().decode()
        code = self.process.wait(WAIT)
        self.reader.join(WAIT)
        for stream in (self.process.stdout, self.process.stderr):
            stream.close()
        return code, errors


def cut(text, place):
    """The characters of a range in UTF-16."""
    (first, a), (last, b) = ((place[end]["line"], place[end]["character"]) for end in ("start", "end"))
    assert first == last
    return text.split("\n")[first].encode("utf-16-le")[2 * a : 2 * b].decode("utf-16-le")


def edited(text, edits):
    """A text after edits, which are given as in the protocol."""
    lines = text.split("\n")
    for edit in sorted(edits, key=lambda x: -x["range"]["start"]["character"]):
        start, end = edit["range"]["start"], edit["range"]["end"]
        assert start["line"] == end["line"]
        line = lines[start["line"]].encode("utf-16-le")
        new = line[: 2 * start["character"]] + edit["newText"].encode("utf-16-le") + line[2 * end["character"] :]
        lines[start["line"]] = new.decode("utf-16-le")
    return "\n".join(lines)


@pytest.fixture
def editor():
    """Functions for the texts of a client."""
    return {"cut": cut, "edited": edited}


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    """``start(*options)``: a session in a folder of its own; all are ended after the tests of the file."""
    clients = []

    def begin(*options, folder=None, **named):
        clients.append(Client(folder or tmp_path_factory.mktemp("models"), *options, **named))
        return clients[-1]

    yield begin
    for client in clients:
        if client.process.poll() is None:
            client.close()


@pytest.fixture(scope="module")
def client(start):
    return start()
