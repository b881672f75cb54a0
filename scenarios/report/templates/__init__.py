"""The report's HTML, in Jinja templates that escape what they are given."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup


@lru_cache(maxsize=1)
def _environment() -> Environment:
    loader = FileSystemLoader(Path(__file__).parent)
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def render(template: str, **values: Any) -> Markup:
    """Fill a template of this folder; every value that is no `Markup` is escaped."""
    return Markup(_environment().get_template(template).render(**values))  # noqa: S704  # escaped by the environment
