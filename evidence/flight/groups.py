"""All groups of flights of docs/evidence/flight.md. Tests: tests/evidence/flight/test_flight.py."""

from __future__ import annotations

from .cases import BESIDE, SEEDS, TRIES, Group, hold, manoeuvre, pairings, share, tumbles
from .tried import TRIED


def all_groups(n: int) -> list[Group]:
    """Everything that is flown, with n random tumbles under each condition, and of the smaller sets in proportion."""
    groups = [tumbles(kind, SEEDS[kind], n, kind == "errors") for kind in ("nominal", "errors")]
    groups += [manoeuvre(which, n=n) for which in ("vb", "vc")]
    for scheme in ("tuned", "paper"):
        for kind in ("nominal", "errors"):
            groups.append(tumbles(f"{kind} {scheme}", SEEDS[kind], share(n, BESIDE), kind == "errors", scheme))
        groups += [manoeuvre(which, scheme, n) for which in ("vb", "vc")]
    return [*groups, hold(n), *pairings(), *(t.group(share(n, TRIES)) for t in TRIED)]
