"""What `armtwin score` prints of every sealed set: the confusion and the rates."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table


def print_confusion(console: Console, confusion: dict[str, dict[str, int]]) -> None:
    """Print what was said of what is true."""
    console.print("What is hidden, and what was said (a|b: a tie)", style="bold")
    for true, said in confusion.items():
        console.print(f"  {true:24s} " + ", ".join(f"{name} {count}" for name, count in said.items()), markup=False)


def print_rates(console: Console, table: dict[str, Any], what: str = "worlds", floors: float = 1.1) -> None:
    """Print every rate beside what is wanted of it."""
    out = Table("", "share", "count", "wanted", "met", title=f"{table['worlds']} sealed {what}")
    for rate in table["rates"].values():
        wanted = " and ".join(
            [f">= {rate['least']:.0%}"] * (rate["least"] > 0) + [f"<= {rate['most']:.0%}"] * (rate["most"] < 1)
        )
        share = "-" if rate["share"] is None else f"{rate['share']:.1%}"
        met = "" if rate["met"] is None or not wanted else "yes" if rate["met"] else "NO"
        out.add_row(rate["title"], share, f"{rate['hits']}/{rate['of']}", wanted, met)
    console.print(out)
    figures = {k: "-" if v is None else f"{v:.3f}" for k, v in table["held_out_over_floor"].items()}
    console.print(
        f"held-out error over the noise floor, named worlds: median {figures['median']} (wanted <= {floors}), "
        f"90 % {figures['p90']}, pooled {figures['pooled']}; by medians {figures['median_of_medians']}"
    )
    seconds = {k: "-" if v is None else f"{v:.1f}" for k, v in table["seconds"].items()}
    console.print(f"CPU seconds a world: median {seconds['median']}, 90 % {seconds['p90']}, most {seconds['most']}")
