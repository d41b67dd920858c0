"""The matrix of requirements: a requirement without evidence is named, and evidence without a requirement."""

from __future__ import annotations

import csv
from importlib import resources

import pytest
import xmlschema
from reqif.parser import ReqIFParser

from evidence.trace import reqif
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


def test_a_tool_of_requirements_reads_the_matrix_in_reqif(tmp_path):
    cells = [["ZZ-1", 'It turns: a < b & "c".', "[8]"], ["ZZ-2", "It stops.", ""]]
    reqif.write(["id", "text", "code"], cells, tmp_path / "trace.reqif")
    content = ReqIFParser.parse(str(tmp_path / "trace.reqif")).core_content.req_if_content
    (kind, _) = content.spec_types
    assert [a.long_name for a in kind.attribute_definitions] == ["ReqIF.ForeignID", "ReqIF.Text", "code"]
    assert [o.identifier for o in content.spec_objects] == ["ZZ-1", "ZZ-2"]
    assert [place.spec_object for place in content.specifications[0].children] == ["ZZ-1", "ZZ-2"]
    schema = resources.files("reqif") / "reqif_schema" / "reqif.xsd"
    assert xmlschema.XMLSchema(str(schema)).is_valid(tmp_path / "trace.reqif")
    for given, read in zip(cells, content.spec_objects, strict=True):
        assert [a.value for a in read.attributes] == given
