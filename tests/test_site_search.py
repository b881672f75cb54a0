"""The site's search works on pages that are opened as files, and asks no network for it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml
from mkdocs.commands.build import build
from mkdocs.config import load_config

from tests.support.browser import CHROMIUM, chromium

ROOT = Path(__file__).parent.parent


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """Return a site of two pages, built as the documentation is."""
    pages = tmp_path / "docs"
    (pages / "deeper").mkdir(parents=True)
    shutil.copytree(ROOT / "docs" / "assets", pages / "assets")
    (pages / "index.md").write_text("# Start\n\nNothing of it here.\n")
    (pages / "deeper" / "play.md").write_text("# Play\n\nA zebra has backlash in its knee.\n")
    table = yaml.safe_load((ROOT / "mkdocs.yml").read_text("utf-8"))
    table |= {"docs_dir": str(pages), "site_dir": str(tmp_path / "site")}
    del table["nav"]
    (tmp_path / "mkdocs.yml").write_text(yaml.safe_dump(table))
    build(load_config(str(tmp_path / "mkdocs.yml")))
    return tmp_path / "site"


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_a_word_is_found_from_every_page_without_a_network(site: Path) -> None:
    with chromium() as browser:
        for page_file in ("index.html", "deeper/play.html"):
            page = browser.new_context().new_page()
            asked: list[str] = []
            page.on("request", lambda request, asked=asked: asked.append(request.url))
            page.goto((site / page_file).as_uri())
            page.click("label.md-search__icon, input.md-search__input")
            page.type("input.md-search__input", "zebra")
            found = page.wait_for_selector(".md-search-result__link")
            assert found is not None
            assert "deeper/play.html" in str(found.get_attribute("href"))
            assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
