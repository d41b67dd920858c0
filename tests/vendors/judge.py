"""Holds what the commands say of a vendor's FMU against its expected answer."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from orchestration.acceptance.check import check
from orchestration.acceptance.polarity.swaps import look
from orchestration.acceptance.polarity.wrongs import signed_permutations, usual_factors
from orchestration.acceptance.suggest import suggest
from orchestration.fmu.interfaces import reference
from orchestration.scenario.mapping import Mapping
from orchestration.scenario.mapping import load as load_mapping
from orchestration.scenario.source import Source
from orchestration.swap.findings import Fit, Link
from orchestration.swap.fit import fit
from orchestration.swap.option import swapped, swaps_of

from .kinds import Case

SIZE = 0.1
"""How near the size of a cause has to be, as a share of it."""


@dataclass
class Verdict:
    """What was said, against what is to be said."""

    proposed: bool | None = None
    """Whether `check --suggest` proposed the right mapping; None where the FMU does not tell it."""
    detected: bool | None = None
    named: bool | None = None
    false: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    left: float = 0.0
    """Share of ours that what is said leaves unexplained."""


def judge(case: Case, path: Path, ours: Source) -> Verdict:
    """Returns what the commands say of an FMU, as far as it is right."""
    verdict = Verdict()
    block = case.vendor.block
    fitted = check(path, block)[1]
    assert fitted is not None
    text = suggest(fitted)
    proposal = path.with_suffix(".yaml")
    proposal.write_text(text, "utf-8")
    mapping = load_mapping(proposal)[0]
    after = fit(reference(block, Path()), fitted.theirs, mapping)
    told = {name: truth for name, truth in case.truth.items() if name not in case.named}
    if case.answer == "right":
        wrong = [name for name, truth in told.items() if not serves(after, name, truth)]
        verdict.proposed = not wrong
        verdict.said += [f"proposal of {name}" for name in wrong]
    looked = look(ours, swapped(ours, swaps_of([f"{block}={path}"], [f"{block}={proposal}"])), [block])
    behaves: dict[str, str] = {}
    final = after
    for mended in looked.mended:
        behaves |= mended.behaves
        if mended.behaves:
            final = fit(reference(block, Path()), fitted.theirs, Mapping.model_validate(mended.mapping))
    verdict.said += [f"{port}: {text}" for port, text in behaves.items()]
    causes = [cause for mended in looked.mended for cause in getattr(mended, "causes", ())]
    verdict.said += [str(cause) for cause in causes]
    verdict.left = max((mended.after for mended in looked.mended if mended.behaves or mended.causes), default=0.0)
    verdict.detected = looked.wrong is not None or any(mended.before > 1e-10 for mended in looked.mended)
    equally = any(_is_truth(words, case) for mended in looked.mended for words in mended.equally)
    verdict.said += [f"or equally well: {words}" for mended in looked.mended for words in mended.equally]
    for port in behaves:
        if not serves(final, port, case.truth[port]) and not equally:
            verdict.false.append(f"{port}: {behaves[port]}")
    for cause in causes:
        if not any(_same(cause, expected) for expected in case.causes):
            verdict.false.append(str(cause))
    right = equally or all(serves(final, port, case.truth[port]) for port in case.named)
    found = all(any(_same(cause, expected) for cause in causes) for expected in case.causes)
    verdict.named = None if case.answer in ("right", "silent") else right and found
    if case.answer == "wrong" and all(serves(after, name, truth) for name, truth in case.truth.items()):
        verdict.proposed = True  # a guess that is right: there is nothing to detect
    if case.answer == "right" or verdict.proposed:
        verdict.detected = None
    return verdict


def _is_truth(words: str, case: Case) -> bool:
    """Whether another wiring that is said to serve equally well, in words, is the one that is to be named."""
    said = dict(part.partition(": ")[::2] for part in words.replace(" (left-handed)", "").split(", "))
    return set(said) == set(case.named) and all(
        case.truth[port][0] == "linear" and _is_read(text, port, case) for port, text in said.items()
    )


def _is_read(text: str, port: str, case: Case) -> bool:
    """Whether theirs = A ours is read so where it is taken for ours: turned, but for its unit, or in another unit."""
    A = case.truth[port][1]
    turns, unit = dict(signed_permutations()), reference(case.vendor.block, Path()).model.variables[port].unit
    if text == "opposite sign":
        return np.allclose(A, -np.eye(len(A)))
    if text in turns:
        return A.shape == (3, 3) and np.allclose(np.linalg.inv(A) * np.abs(A).max(), turns[text])
    factor = dict(usual_factors(unit, rare=True)).get(text) if unit else None
    return factor is not None and np.allclose(A * factor, np.eye(len(A)))


def serves(fitted: Fit, ours: str, truth: tuple[Any, ...]) -> bool:
    """Whether a port is mapped as its truth says."""
    link: Link | None = fitted.links.get(ours)
    if link is None:
        return False
    if truth[0] == "linear":
        if link.A is None or link.c is None:
            return False
        A, c = truth[1], truth[2]
        if len(A) == len(link.theirs):  # their elements may stand in another order
            references = [fitted.theirs.variables[e.variable].references for e in link.theirs]
            at = [
                (r[e.position] if len(r) > 1 else r[0] + e.position) & 0xFFFF
                for r, e in zip(references, link.theirs, strict=True)
            ]
            order = [at_ - min(at) for at_ in at]
            A, c = A[order], c[order]
        alike = link.A.shape == A.shape and np.allclose(link.A, A, rtol=1e-6, atol=1e-9 * np.abs(A).max())
        return alike and np.allclose(link.c, c, rtol=1e-6, atol=1e-9)
    if truth[0] == "quaternion":
        return link.A is None and (link.scalar_last, link.inverse) == truth[1:] and not getattr(link, "rotation", None)
    if truth[0] == "rotation":
        return getattr(link, "rotation", None) == truth[1] and link.inverse == truth[2]
    return bool(getattr(link, "turned", None))


def _same(cause: Any, expected: tuple[str, str, float]) -> bool:
    kind, where, size = expected
    if kind == "parameter" and cause.kind == kind:
        return any(n == where and abs(f - size) <= SIZE * size for n, f in ((cause.where, cause.size), *cause.equally))
    if any(kind == other for other, _ in cause.equally):
        cause = replace(cause, kind=kind, size=dict(cause.equally)[kind], equally=())
    if cause.kind != kind or cause.where.partition("[")[0] != where.partition("[")[0]:
        return False
    if "[" in where and "[" in cause.where and cause.where != where:
        return False
    return size == 0.0 or abs(cause.size - size) <= SIZE * abs(size)
