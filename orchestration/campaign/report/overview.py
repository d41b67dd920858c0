"""The head of a campaign's page: its outcome, how it was made, and the verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from ...results import html
from ...results.html import facts, verdict
from ..statistics.verdicts import ends, percent

_BASIS = {
    "latin hypercube": "They are those of independent draws; a Latin hypercube makes them wider than needed as a rule.",
    "sobol": "They are those of independent draws; scrambled Sobol' points make them wider than needed as a rule.",
    "grid": "A full grid is no draw: read the shares as shares of the grid's points.",
}


def basis(manifest: dict[str, Any]) -> str:
    if manifest["early"]:
        return "They hold at all looks at once (a confidence sequence), so stopping early keeps the confidence."
    return _BASIS.get(
        manifest["sampling"], "They hold for a number of runs that was fixed before (Clopper and Pearson)."
    )


def outcome(manifest: dict[str, Any]) -> tuple[str, str]:
    """Returns a class for its colour, and the outcome in words."""
    statuses = [v["status"] for v in manifest["verdicts"]]
    if not statuses:
        return "plain", "no requirements"
    if set(statuses) == {"met"}:
        return "good", f"all {len(statuses)} requirements met" if len(statuses) > 1 else "the requirement is met"
    counts = {word: statuses.count(word) for word in ("met", "not met", "undecided") if word in statuses}
    kind = "bad" if "not met" in counts else "warn"
    return kind, ", ".join(f"{n} of {len(statuses)} requirements {word}" for word, n in counts.items())


def header(manifest: dict[str, Any]) -> Markup:
    counts = manifest["runs"]
    badges = [outcome(manifest)]
    if counts["failed"]:
        badges.append(("warn", f"{counts['failed']:,} run{'s' * (counts['failed'] > 1)} failed"))
    if manifest["state"] != "completed":
        badges.append(("plain" if manifest["state"] == "stopped early" else "bad", manifest["state"]))
    seconds = manifest.get("wall_time") or 0.0
    rate = f", {counts['flown'] / seconds:,.3g} runs/s" if seconds else ""
    few = f" of {counts['wanted']:,}" if counts["flown"] < counts["wanted"] else ""
    seed = "" if manifest["sampling"] == "grid" else f", seed {manifest['seed']}"
    entries = {
        "runs": f"{counts['flown']:,}{few}",
        "failed runs": f"{counts['failed']:,}" if counts["failed"] else "",
        "drawn": f"{manifest['sampling']}{seed}",
        "scenario": manifest.get("scenario_file") or manifest.get("scenario") or "",
        "wall time": f"{seconds:,.3g} s{rate}",
        "finished": str(manifest.get("finished") or "").replace("T", " ").replace("+00:00", " UTC"),
    }
    return html.header(manifest["campaign"], manifest.get("description") or "", badges, facts(entries))


def verdicts(manifest: dict[str, Any]) -> list[list[object]]:
    asked = {r["name"]: r for r in manifest["requirements"]}
    lines: list[list[object]] = []
    for v in manifest["verdicts"]:
        r = asked[v["name"]]
        of = r.get("metric") or r.get("expectation") or ""
        lines.append([
            verdict(v["status"]),
            two(v["name"], of if of != v["name"] else ""),
            r["expected"],
            two(f"{v['probability']:g}", f"at {percent(v['confidence'])} confidence"),
            two(f"{v['share']:.5g}" if v["share"] is not None else "\N{EN DASH}",
                 ends(v["low"], v["high"])),
            v["text"],
        ])  # fmt: skip
    return lines


def failures(reasons: Mapping[int, str]) -> list[list[object]]:
    """Returns how many runs failed for each reason, and the first five of them; the most frequent first."""
    runs: dict[str, list[int]] = {}
    for index, reason in sorted(reasons.items()):
        runs.setdefault(reason, []).append(index)
    frequent = sorted(runs.items(), key=lambda entry: (-len(entry[1]), entry[1]))
    return [[f"{len(indices):,}", reason, ", ".join(map(str, indices[:5]))] for reason, indices in frequent]


def two(text: str, below: str) -> Markup:
    return Markup("{}<small>{}</small>").format(text, below)
