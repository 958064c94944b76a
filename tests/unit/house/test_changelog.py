"""The changelog and the version agree; a change since the last release is one line."""

import re
from datetime import date
from pathlib import Path

import mbdsl

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (.+)\n((?:(?!## ).*\n)*)", TEXT, re.MULTILINE))
RELEASES = [
    re.fullmatch(r"(\d+)\.(\d+)\.(\d+) \((\d{4}-\d\d-\d\d)\)", name) for name in SECTIONS if name != "Unreleased"
]


def test_the_first_section_is_of_changes_since_the_release():
    assert next(iter(SECTIONS)) == "Unreleased"
    lines = [line for line in SECTIONS["Unreleased"].splitlines() if line]
    assert not [line for line in lines if not line.startswith("- ")]


def test_releases_are_in_order_and_have_dates():
    assert RELEASES and all(RELEASES)
    numbers = [tuple(int(part) for part in found.groups()[:3]) for found in RELEASES]
    dates = [date.fromisoformat(found[4]) for found in RELEASES]
    assert numbers == sorted(numbers, reverse=True) and dates == sorted(dates, reverse=True)


def test_the_version_is_the_newest_release_or_develops_from_it():
    """``0.1.0`` at the release, a later number with ``.dev0`` behind it; citations name the release."""
    released = tuple(int(part) for part in RELEASES[0].groups()[:3])
    number, _, development = mbdsl.__version__.partition(".dev")
    version = tuple(int(part) for part in number.split("."))
    assert version > released if development else version == released
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {'.'.join(map(str, released))}\n" in cited


def test_a_release_has_at_most_sixty_lines():
    assert not [name for name, text in SECTIONS.items() if name != "Unreleased" and len(text.splitlines()) > 60]


def test_links_lead_to_pages():
    links = re.findall(r"\]\((docs/[^)#]+)", TEXT)
    assert len(links) > 20 and not [link for link in links if not (ROOT / link).is_file()]
