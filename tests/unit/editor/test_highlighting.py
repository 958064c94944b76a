"""Highlighting: the Pygments lexer and the grammar for VS Code agree with the lexer of the language on all models."""

import json
import plistlib
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pygments.token import Comment, Error, Keyword, Name, Number, String

from mbdsl.editor import textmate
from mbdsl.editor.pygments_lexer import MbdLexer
from mbdsl.editor.vocabulary import FUNCTION_DOCS, KEYWORD_DOCS, words
from mbdsl.elements import kinds
from mbdsl.errors import SyntaxProblem
from mbdsl.lang import lexer, units
from mbdsl.lang.functions import FUNCTIONS
from mbdsl.lang.lexer import KEYWORDS, tokenize
from mbdsl.lang.source import Source

ROOT = Path(__file__).parents[3]
VSCODE = ROOT / "editors" / "vscode"
MODELS = sorted((ROOT / "models").rglob("*.mbd"))
TEXTS = [path.read_text(encoding="utf-8") for path in MODELS]


# -- the lexer for texts with errors --------------------------------------------------------------------------------
def test_it_cuts_the_tokens_of_the_language():
    """A number and its unit are two pieces of one token."""
    assert len(TEXTS) > 80
    for text in TEXTS:
        pieces = [p for p in lexer.pieces(text) if p.kind != lexer.COMMENT]
        whole = [(t.start, t.end) for t in tokenize(Source("", text))[:-1]]
        joined, previous = [], ""
        for piece in pieces:
            if (previous, piece.kind) == (lexer.NUMBER, lexer.UNIT):
                joined[-1] = (joined[-1][0], piece.end)
            else:
                joined.append((piece.start, piece.end))
            previous = piece.kind
        assert joined == whole


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ('Rod r "ab', ["name", "name", "string"]),
        ("2 m /* ab", ["number", "unit", "comment"]),
        ("§ x[2] h {1} mm", ["wrong", "name", "operator", "number", "operator", "name", "operator"]),
        (")]}", ["operator"] * 3),
        ("", []),
    ],
)
def test_incomplete_texts(text, kinds):
    assert [p.kind for p in lexer.pieces(text)][: len(kinds)] == kinds


def test_units_follow_numbers_and_literals_only():
    found = [p.text for p in lexer.pieces("3 kg + x[1] m + {1, 2} mm + [1; 2] N.m/rad") if p.kind == "unit"]
    assert found == ["kg", "mm", "N.m/rad"]


@pytest.mark.parametrize("text", ['"' + '\\"\n' * 50_000, "/*" * 100_000, '"\n' * 50_001, "(" * 200_000])
def test_time_is_linear(text):
    """With quadratic time each of these would take minutes."""
    assert "".join(p.text for p in lexer.pieces(text)).replace("\n", "") == text.replace("\n", "")


# -- Pygments -------------------------------------------------------------------------------------------------------
def test_every_model_is_cut_without_errors():
    for path, text in zip(MODELS, TEXTS, strict=True):
        found = list(MbdLexer().get_tokens_unprocessed(text))
        assert "".join(part for _, _, part in found) == text
        assert [part for _, kind, part in found if kind is Error] == [], path
        assert all(text.startswith(part, at) for at, _, part in found)


def test_classes_of_words():
    text = 'model A "doc" Rod r(m = 3 kg); /* b */ parameter Mass q = sin(pi) § // c'
    found = {part: kind for _, kind, part in MbdLexer().get_tokens_unprocessed(text)}
    assert found["model"] is Keyword and found["Rod"] is Name.Class and found["3"] is Number
    assert found["kg"] is Keyword.Type and found["Mass"] is Keyword.Type and found["§"] is Error
    assert found["sin"] is Name.Builtin and found["pi"] is Name.Constant and found["r"] is Name
    assert found['"doc"'] is String.Double and found["/* b */"] is Comment.Multiline


def test_pygments_finds_the_lexer_by_its_name(tmp_path):
    """As installed: the entry point of pyproject.toml, in the metadata of a package."""
    section = re.search(
        r'\[project\.entry-points\."pygments\.lexers"\]\n(.*?)\n\n', (ROOT / "pyproject.toml").read_text(), re.DOTALL
    )
    metadata = tmp_path / "entry-0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: entry\nVersion: 0\n")
    (metadata / "entry_points.txt").write_text("[pygments.lexers]\n" + section[1].replace('"', "") + "\n")
    code = "from pygments.lexers import *; print(get_lexer_by_name('mbd').name, get_lexer_for_filename('a.mbd').name)"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(ROOT)!r}]; {code}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "mbdsl mbdsl\n"


# -- the grammar for VS Code ----------------------------------------------------------------------------------------
def test_the_grammar_as_a_property_list():
    assert plistlib.loads(textmate.content("mbd.tmLanguage")) == textmate.grammar()


def test_words_of_the_grammar_are_those_of_the_language():
    found = words()
    listed = [word for group in found.values() for word in group]
    assert len(listed) == len(set(listed))
    assert {*KEYWORDS, *kinds(), *FUNCTIONS} <= set(listed)
    patterns = " ".join(p.get("match", "") for p in textmate.grammar()["patterns"])
    assert all(re.search(rf"[:|(]{word}[|)]", patterns) for word in listed)


def test_described_words_exist():
    assert set(KEYWORD_DOCS) == set(words()["keyword"])
    assert set(FUNCTION_DOCS) <= set(words()["function"])


def test_units_of_the_grammar_are_those_of_the_language():
    """All symbols with and without exponents, names that are not units, and the units of all models."""
    pattern = re.compile(textmate.unit_pattern())
    written = {p.text for text in TEXTS for p in lexer.pieces(text) if p.kind == lexer.UNIT}
    assert len(written) > 30
    symbols = [*units.symbols(), "x", "kkg", "Nm", "m1", "m_a", "cT", "dt", "µµm", "degree"]
    powers = ["", "2", "^2", "^(-1)", "^-1", "1", "10", "a"]
    for text in [*written, *(s + power for s in symbols for power in powers), "kg/(m.s)", "m/L2", "N.m/rad)", "m.", ""]:
        known, found = units.scan(text), pattern.match(text)
        assert (known[1] if known else 0) == (found.end() if found else 0), text


def tokens(text):
    """[(text, scope)] by the rules of TextMate: the first pattern that matches at the earliest place."""
    patterns = [(p, re.compile(p.get("match") or p["begin"], re.MULTILINE)) for p in textmate.grammar()["patterns"]]
    at, found = 0, []
    while at < len(text):
        matches = [(m.start(), k, m) for k, (_, e) in enumerate(patterns) if (m := e.search(text, at)) and m.group()]
        if not matches:
            break
        _, k, match = min(matches, key=lambda x: x[:2])
        p, at = patterns[k][0], match.end()
        if "end" in p:
            end = re.compile(r'(?:\\.|[^"\\])*"' if p["end"] == '"' else f"(?s:.*?){p['end']}").match(text, at)
            at = end.end()
            found.append((text[match.start() : at], p["name"]))
        elif "captures" in p:
            found += [(match[int(n)], c["name"]) for n, c in p["captures"].items() if match[int(n)]]
        else:
            found.append((match.group(), p["name"]))
    return found


def test_the_grammar_cuts_all_models_as_the_language_does():
    scopes = {"comment": "comment", "string": "string", "number": "constant.numeric", "unit": "keyword.other.unit"}
    for text in TEXTS[:20]:
        found = tokens(text)
        for kind, scope in scopes.items():
            expected = [p.text for p in lexer.pieces(text) if p.kind == kind]
            assert [word for word, name in found if name.startswith(scope)] == expected
        kinds_found = {word for word, name in found if name == "support.class.mbd"}
        assert kinds_found <= set(words()["kind"]) and "Ground" in kinds_found


def test_files_of_the_extension():
    """Every file that package.json names exists, and the files are JSON."""
    package = json.loads((VSCODE / "package.json").read_text(encoding="utf-8"))
    contributed = package["contributes"]
    named = [contributed["languages"][0]["configuration"], contributed["grammars"][0]["path"], package["main"]]
    assert all((VSCODE / name).is_file() for name in named)
    json.loads((VSCODE / named[0]).read_text(encoding="utf-8"))
    assert contributed["languages"][0]["extensions"] == [".mbd"]


def test_the_lexer_of_the_language_still_refuses():
    """The loose lexer replaces the strict one nowhere."""
    with pytest.raises(SyntaxProblem):
        tokenize(Source("", 'model A "a'))
