"""The documentation: its pages name commands and options that there are, and links that lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from armtwin.scenarios.cli import COMMANDS, build_app

DOCS = Path(__file__).parent.parent / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
LINK = re.compile(r"\]\((?!https?://|#)([^)#]+)")
# Pages that are made when the site is built.
MADE = {
    *("reference/effects.md", "reference/commands.md", "reference/python.md", "labs/solutions.md"),
    *("tutorials/own-bench.md", "tutorials/own-effect.md", "pictures/frame.jpg", "pictures/report.html"),
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_to_pages(page: Path) -> None:
    for target in LINK.findall(page.read_text("utf-8")):
        path = (page.parent / target).resolve()
        assert path.is_file() or path.relative_to(DOCS.resolve()).as_posix() in MADE, target


def test_every_page_stands_in_the_menu() -> None:
    menu = (DOCS.parent / "mkdocs.yml").read_text("utf-8")
    listed = set(re.findall(r"[\w/-]+\.md", yaml.safe_dump(yaml.safe_load(menu)["nav"])))
    assert {page.relative_to(DOCS).as_posix() for page in PAGES} | {
        name for name in MADE if name[-3:] == ".md"
    } == listed


def test_commands_and_options_on_the_pages_are_known() -> None:
    text = "\n".join(page.read_text("utf-8") for page in PAGES)
    calls = [line for block in re.findall(r"```sh\n(.*?)```", text, re.S) for line in block.splitlines()]
    used = [line.split("#")[0].split() for line in calls if line.startswith("armtwin ")]
    assert len(used) > 10
    for _, name, *words in used:
        assert name in COMMANDS, name
        app = build_app(name)
        family = {one.name for group in app.registered_groups for one in group.typer_instance.registered_commands}
        called = [name, *words[:1]] if family else [name]
        assert not family or called[-1] in family, called
        told = CliRunner().invoke(app, [*called, "--help"], env={"COLUMNS": "200"}).output
        for option in (word for word in words if word.startswith("--")):
            assert option in told, f"{name} {option}"
