"""The matrix of requirements: a requirement without evidence is named, and evidence without a requirement."""

from __future__ import annotations

import csv

import pytest

from evidence.trace.matrix import Requirement, make, matrix, requirements, write
from orchestration import InputError


def planted(tmp_path, **files):
    for name, text in files.items():
        folder = tmp_path / {"code": "allocator", "test": "tests", "proof": "evidence/proofs"}[name.partition("_")[0]]
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.py").write_text(text)
    return matrix({"ZZ-1": Requirement("ZZ-1", "It turns.", "[8]")}, tmp_path)


def test_each_requirement_of_the_project_has_code_and_a_test_or_a_proof():
    rows, strangers = matrix(requirements())
    assert len(rows) >= 15
    assert [r.id for r in rows if r.lacks] == []
    assert strangers == []


def test_a_planted_requirement_without_a_test_is_named(tmp_path, monkeypatch):
    file = tmp_path / "requirements.yaml"
    file.write_text("- {id: FC-99, text: Nobody shows this., source: a dream}\n")
    monkeypatch.setattr("evidence.trace.matrix.requirements", lambda: requirements() | requirements(file))
    monkeypatch.setattr("evidence.trace.matrix.write", lambda rows: tmp_path)
    with pytest.raises(InputError, match="FC-99: Nobody shows this. lacks code"):
        make()


@pytest.mark.parametrize(
    ("files", "lacks"),
    [
        ({"code_a": "'''ZZ-1'''"}, "a test or a proof"),
        ({"test_a": "'''ZZ-1'''"}, "code"),
        ({"code_a": "'''ZZ-1'''", "test_a": "'''Shows ZZ-1.'''"}, ""),
        ({"code_a": "'''ZZ-1'''", "test_a": "'''Shows ZZ-10.'''"}, "a test or a proof"),
    ],
)
def test_a_requirement_needs_code_and_a_test(tmp_path, files, lacks):
    rows, _ = planted(tmp_path, **files)
    assert rows[0].lacks == lacks


def test_evidence_of_no_requirement_is_named(tmp_path):
    _, strangers = planted(tmp_path, test_a="'''Shows ZZ-7.'''")
    assert strangers == ["tests/test_a.py: ZZ-7"]


def test_the_table_and_the_page_show_each_requirement_with_its_files(tmp_path):
    rows, _ = planted(tmp_path, code_a="'''ZZ-1'''", test_a="'''ZZ-1'''")
    page = write(rows, tmp_path / "out")
    table = list(csv.DictReader((tmp_path / "out" / "trace.csv").open(encoding="utf-8")))
    assert (table[0]["code"], table[0]["tests"], table[0]["lacks"]) == ("allocator/code_a.py", "tests/test_a.py", "")
    assert "<td>allocator/code_a.py</td>" in page.read_text("utf-8")
