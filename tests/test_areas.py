"""Which changes a seed may draw in an area's code: operators and numbers of code, nothing of text and comments. And the
compiler that compiles what has changed alone."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from . import covered, mutants_of_c, objects
from .areas import AREAS, EQUIVALENT, ROOT, change_of, changes, drawn, fails, within


def changed(tmp_path: Path, name: str, text: str) -> set[str]:
    (tmp_path / name).write_text(text)
    return {text[:begin] + other + text[end:] for begin, end, other in changes(tmp_path / name)}


def test_c_is_changed_in_binary_operators_and_numbers_outside_comments_text_and_directives(tmp_path):
    text = '#define N 1\nint f(int *a)\n{\n    /* a < 1 */ say("1 < 2"); return a->n < 10 && -x + 1 > *a; // 0\n}\n'
    for old, new in (("n < 10", "n <= 10"), ("&&", "||"), ("x + 1", "x - 1"), ("+ 1 ", "+ 2 "), ("1 > *", "1 >= *")):
        assert text.replace(old, new) in changed(tmp_path, "a.c", text)
    assert len(changed(tmp_path, "a.c", text)) == 5


def test_python_is_changed_within_functions_where_it_stays_python(tmp_path):
    text = 'N = 1\ndef f(a, *b):\n    "1 < 2"\n    return [x for x in b if not a < x]  # 0\n'
    expected = {text.replace("not a", " a"), text.replace("a < x", "a <= x")}
    assert changed(tmp_path, "a.py", text) == expected


@pytest.mark.parametrize("area", AREAS)
def test_the_code_and_the_tests_of_an_area_are_there(area):
    sources, tests = AREAS[area]
    assert all(any(ROOT.glob(pattern)) for pattern in sources)
    assert all((ROOT / test).exists() for test in tests)


def test_each_change_that_no_test_can_see_can_be_drawn():
    drawn = set()
    for path in {ROOT / entry.partition(": ")[0] for entry in EQUIVALENT}:
        for change in (change_of(ROOT, path, 1, *each) for each in changes(path)):
            if any(entry.startswith(f"{change.file}: {change.words}") for entry in EQUIVALENT):
                drawn.update(change.names)
    assert EQUIVALENT.keys() <= drawn


def test_a_seed_draws_the_same_changes_again_and_fewer_of_them_are_the_first_ones():
    first, again = (list(drawn(ROOT, "supervisor in C", count, 3)) for count in (4, 2))
    assert first[:2] == again
    for change in first:
        text = (ROOT / change.file).read_text("utf-8")
        differ = [i for i, (a, b) in enumerate(zip(text.splitlines(), change.text.splitlines(), strict=True)) if a != b]
        assert differ == [change.line - 1]


def test_the_quickest_tests_come_first_within_a_time_and_one_at_least():
    times = {"a": 1.0, "b": 2.0, "c": 4.0}
    assert within("abc", times, 3.5) == (["a", "b"], ["c"])
    assert within("abc", times, 0.0) == (["a"], ["b", "c"])
    assert within("", times, 9.0) == ([], [])


@pytest.mark.isolate
def test_a_line_is_tried_with_the_tests_that_run_it_also_in_processes_that_they_start(tmp_path):
    code = (
        "def f(x):\n    y = (x +\n         1)\n    return y\n\n"
        "def g(x):\n    return -x\n\nif __name__ == '__main__':\n    g(1)\n"
    )
    tests = (
        "import subprocess, sys, pytest, code_\n@pytest.mark.parametrize('x', ['|', ' (a)'])\n"
        "def test_f(x): code_.f(1)\ndef test_g(): subprocess.run([sys.executable, 'code_.py'], check=True)\n"
        "def test_fails(): code_.g(1); assert False\n"
    )
    file, settings = tmp_path / "code_.py", tmp_path / "settings.ini"
    for path, text in (
        (file, code),
        (tmp_path / "test_it.py", tests),
        (tmp_path / "pytest.ini", "[pytest]\npythonpath = .\n"),
        (tmp_path / "sitecustomize.py", covered.BEGIN),
        (settings, covered.SETTINGS.format(files=file, data=tmp_path)),
    ):
        path.write_text(text)
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    own |= {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}", "COVERED": str(tmp_path)}
    command = [sys.executable, "-m", "pytest", "-q", "-n1", "-p", "tests.covered", "test_it.py"]
    run = subprocess.run(command, cwd=tmp_path, env=own | {"COVERAGE_PROCESS_START": str(settings)}, check=False)
    assert run.returncode == 1
    lines = covered.read(tmp_path)
    assert lines.failed == ["test_it.py::test_fails"]
    f, g = {"test_it.py::test_f[|]", "test_it.py::test_f[ (a)]"}, {"test_it.py::test_g"}
    for line, near, other in ((3, f, g), (4, f, g), (7, g, f), (6, f | g, set())):
        assert tuple(map(set, lines.of(file, code, line))) == (near, other)


@pytest.mark.isolate
@pytest.mark.parametrize(
    ("code", "seen"),
    [
        ("N = 1", False),
        ("N = 2", True),
        ("import none_such", True),
        ("N = 1; IDS = 'b'", False),
        ("IDS = 'b'", True),
    ],
)
def test_a_change_is_seen_by_a_test_that_fails_or_cannot_be_imported_not_by_one_that_has_another_name(
    tmp_path, code, seen
):
    (tmp_path / "code_.py").write_text(f"N, ID = 3, 'a'\n{code}\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\npythonpath = .\n")
    (tmp_path / "test_it.py").write_text(
        "import pytest, code_\n@pytest.mark.parametrize('x', [1], ids=[code_.ID])\ndef test_n(x): assert code_.N == x\n"
    )
    assert fails(tmp_path, ["test_it.py::test_n[a]"], 60.0) is seen


@pytest.mark.compile
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no system compiler")
def test_the_compiler_keeps_the_objects_of_what_has_not_changed(tmp_path):
    sources, kept = [tmp_path / "a.c", tmp_path / "b.c"], tmp_path / "kept"
    kept.mkdir()
    (tmp_path / "n.h").write_text("enum { N = 2 };\n")
    sources[0].write_text('#include "n.h"\nint b(void);\nint a(void) { return 10 * N + b(); }\n')
    for value, count in ((3, 2), (4, 3), (3, 3)):
        sources[1].write_text(f"int b(void) {{ return {value}; }}\n")
        library = tmp_path / f"made{value}{count}.so"
        options = ["-shared", "-fPIC", f"-I{tmp_path}", *map(str, sources), "-o", str(library)]
        assert objects.main(kept, "cc", options) == 0
        assert len(list(kept.iterdir())) == count
        assert ctypes.CDLL(str(library)).a() == 20 + value
    (tmp_path / "n.h").write_text("enum { N = 5 };\n")
    assert objects.main(kept, "cc", [*options[:-1], str(tmp_path / "other.so")]) == 0
    assert ctypes.CDLL(str(tmp_path / "other.so")).a() == 53


def test_a_change_of_c_is_tried_with_the_tests_of_its_statement_and_outside_functions_with_those_of_the_file():
    lines, functions = {4: {"a", "b"}, 6: {"b"}, 9: set(), 10: {"c"}}, {(3, 7), (9, 11)}
    for line, tests in ((4, {"a", "b"}), (5, {"a", "b"}), (7, {"b"}), (9, set()), (11, {"c"}), (1, {"a", "b", "c"})):
        assert mutants_of_c.executing(lines, functions, line) == tests
