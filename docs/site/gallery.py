"""The gallery of scenarios: each is run, and shown with its figures, its expectations and its report.
Tests: tests/docs/test_site.py."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import yaml
from click.testing import CliRunner

from docs.site.live import flights
from orchestration.cli.main import main

ROOT = Path(__file__).parents[2]
HEAD = """# Gallery of scenarios

Each scenario below is a file in `scenarios/`.
Its figures and its table come from a run that was made when this site was built.
The report of a run has interactive plots of all recorded signals.
"""

_SIGNALS = re.compile(r'<a href="signals\.\w+">[^<]*</a>, ')
"""The link to a run's samples, which are too many for the site."""


def page(out: Path) -> str:
    """The gallery's Markdown; runs every scenario and puts figures and reports beside the page."""
    sections = [HEAD, flights()]
    for path in sorted((ROOT / "scenarios").glob("*.yaml")):
        scenario = yaml.safe_load(path.read_text("utf-8"))
        results = out / "runs" / path.stem
        given = ["run", str(path), "--quiet", "--figures", "--out", str(results)]
        status = CliRunner().invoke(main, given).exit_code
        if status > 1:
            raise RuntimeError(f"{path.name}: exit status {status}")
        shown = out / "pages" / "docs" / "gallery" / path.stem
        shown.mkdir(parents=True, exist_ok=True)
        for made in (*results.glob("figures/*.png"), *results.glob("*.json")):
            shutil.copy(made, shown)
        report = (results / "report.html").read_text("utf-8")
        (shown / "report.html").write_text(_SIGNALS.sub("", report), "utf-8")
        sections.append(section(path.stem, scenario, json.loads((results / "expectations.json").read_text("utf-8"))))
    return "\n".join(sections)


def section(name: str, scenario: dict[str, Any], outcome: dict[str, Any]) -> str:
    """One scenario's part of the page."""
    lines = [f"## {name}", "", scenario["description"] + ".", ""]
    lines += [f"[Scenario file](../scenarios/{name}.yaml) · [report](gallery/{name}/report.html)", ""]
    lines += ["```", f"orchestrate scenarios/{name}.yaml --figures", "```", ""]
    for figure in scenario.get("figures", ()):
        lines += [f"![{figure['title']}](gallery/{name}/{figure['name']}.png)", ""]
    lines += ["| expectation | expected | value | result |", "|---|---|---|---|"]
    for row in outcome["expectations"]:
        value = f"{row['found']:.4g} {row['unit']}" if isinstance(row["found"], float) else str(row["found"])
        lines.append(f"| {row['name']} | {row['expected']} | {value} | {'met' if row['passed'] else '**failed**'} |")
    return "\n".join([*lines, ""])
