"""The matrix of requirements: a requirement without evidence is named, and evidence without a requirement."""

from __future__ import annotations

import csv
from importlib import resources

import pytest
import xmlschema
from reqif.parser import ReqIFParser

from evidence.trace import reqif
from evidence.trace.matrix import Requirement, make, matrix, requirements, write
from evidence.trace.ran import passed
from orchestration import InputError

PROOFS = "evidence/proofs"


def planted(tmp_path, **files):
    """A project of files, such as `code_a`, `c_a`, `test_a`, `proof_a` and `flown_a`, and one requirement."""
    folders = {
        "code": "allocator",
        "c": "allocator",
        "test": "tests",
        "proof": PROOFS,
        "make": PROOFS,
        "flown": "scenarios",
    }
    for name, text in files.items():
        kind = name.partition("_")[0]
        folder = tmp_path / folders[kind]
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.{ {'c': 'c', 'flown': 'yaml'}.get(kind, 'py') }".replace(" ", "")).write_text(text)
    return matrix({"ZZ-1": Requirement("ZZ-1", "It turns.", "[8]")}, tmp_path)


C = "/* A wheel. Requirement: ZZ-1. Tests: a.py. */\nint x;\n"
OF_ALL = "'''Of all.\n\nShows ZZ-1.\n'''\n"
SHOWN = "import ctypes\n\ndef test_it():\n    '''It turns.\n\n    Shows ZZ-1.\n    '''\n    assert turned()\n"


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
    monkeypatch.setattr("evidence.trace.matrix.passed", lambda files, root: {})
    with pytest.raises(InputError, match="FC-99: Nobody shows this. lacks code in C"):
        make()


@pytest.mark.parametrize(
    ("files", "lacks"),
    [
        ({"c_a": C}, "a test or a proof"),
        ({"test_a": SHOWN}, "code in C"),
        ({"code_a": "'''Requirement: ZZ-1.'''", "test_a": SHOWN}, "code in C"),
        ({"c_a": "int x; /* Requirement: ZZ-1. */\n", "test_a": SHOWN}, "code in C"),
        ({"c_a": "/* ZZ-1 is to be written. */\n", "test_a": SHOWN}, "code in C"),
        ({"c_a": "/* More.\n * Requirements: AB-1, ZZ-1. Tests: a.py. */\nint x;\n", "test_a": SHOWN}, ""),
        ({"c_a": C.replace("int x;", '#include "x.h"'), "test_a": SHOWN}, "code in C"),
        ({"c_a": C, "test_a": "# Shows ZZ-1.\n" + SHOWN.replace("Shows", "Not yet:")}, "a test or a proof"),
        ({"c_a": C, "test_a": SHOWN.replace("ZZ-1", "ZZ-10")}, "a test or a proof"),
        ({"c_a": C, "test_a": "'''Shows ZZ-1.'''\n"}, "a test or a proof"),
        ({"c_a": C, "test_a": SHOWN.replace("test_it", "helper")}, "a test or a proof"),
        ({"c_a": C, "test_a": SHOWN.replace("import ctypes", "import math")}, "a test that runs C"),
        ({"c_a": C, "test_a": SHOWN.replace("import ctypes", "from . import test_b"), "test_b": "import ctypes\n"}, ""),
        ({"c_a": C, "flown_a": "# Shows ZZ-1.\nname: a\n"}, "a test or a proof"),
        ({"c_a": C, "test_a": "def helper():\n    def test_it():\n        '''Shows ZZ-1.'''\n"}, "a test or a proof"),
        ({"c_a": C, "proof_a": OF_ALL, "make": "from .other import of\n"}, "a test or a proof"),
        ({"c_a": C, "proof_a": OF_ALL, "make": "from . import proof_b\n", "proof_b": "from .proof_a import of\n"}, ""),
    ],
)
def test_a_requirement_needs_c_and_a_test_or_a_proof_that_says_so(tmp_path, files, lacks):
    rows, _ = planted(tmp_path, **files)
    assert rows[0].lacks == lacks


RUN = {
    "passes": "def test_it():\n    assert sum([1]) == 1\n",
    "fails": "def test_it():\n    assert sum([1]) == 2\n",
    "skips": "import pytest\n@pytest.mark.skipif(not False, reason='')\ndef test_it():\n    pass\n",
    "leaves": "import pytest\n@pytest.fixture(autouse=True)\ndef out():\n    pytest.skip()\ndef test_it():\n    pass\n",
    "lacks": "import pytest\npytest.importorskip('no_such_module')\ndef test_it():\n    pass\n",
    "none": "import pytest\n@pytest.mark.parametrize('x', [])\ndef test_it(x):\n    pass\n",
    "off": "__test__ = False\ndef test_it():\n    pass\n",
    "some": "import pytest\n@pytest.mark.parametrize('x', [1, 2])\ndef test_it(x):\n    assert x == 1\n",
}


def test_a_test_that_fails_or_is_skipped_in_any_way_is_no_evidence(tmp_path):
    for name, text in RUN.items():
        (tmp_path / f"test_{name}.py").write_text(text)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    good = passed([f"test_{name}.py" for name in RUN], tmp_path)
    assert {file: names for file, names in good.items() if names} == {"test_passes.py": {"test_it"}}


def test_of_a_module_all_tests_have_to_pass(tmp_path):
    files = {"c_a": C, "test_a": f"{OF_ALL}import ctypes\ndef test_a():\n    pass\ndef test_b():\n    pass\n"}
    assert planted(tmp_path, **files)[0][0].lacks == ""
    for names, lacks in (({"test_a", "test_b"}, ""), ({"test_a"}, "a test or a proof"), (set(), "a test or a proof")):
        known = {"ZZ-1": Requirement("ZZ-1", "It turns.", "[8]")}
        assert matrix(known, tmp_path, {"tests/test_a.py": names})[0][0].lacks == lacks


@pytest.mark.parametrize("stranger", ["ZZ-7", "QQ-1"])
def test_evidence_of_no_requirement_is_named(tmp_path, stranger):
    _, strangers = planted(tmp_path, test_a=SHOWN.replace("ZZ-1", stranger), flown_a=f"# Shows ZZ-1, {stranger}.\n")
    assert strangers == [f"tests/test_a.py: {stranger}", f"scenarios/flown_a.yaml: {stranger}"]


def test_the_table_and_the_page_show_each_requirement_with_its_files(tmp_path):
    rows, _ = planted(tmp_path, c_a=C, test_a=SHOWN, flown_a="# A flight.\n# Shows ZZ-1.\n")
    page = write(rows, tmp_path / "out")
    table = list(csv.DictReader((tmp_path / "out" / "trace.csv").open(encoding="utf-8")))
    assert table[0]["code in C"] == "allocator/c_a.c"
    assert (table[0]["tests"], table[0]["scenarios"], table[0]["lacks"]) == (
        "tests/test_a.py",
        "scenarios/flown_a.yaml",
        "",
    )
    assert "<td>allocator/c_a.c</td>" in page.read_text("utf-8")


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
