"""Which changes a seed may draw in an area's code: operators and numbers of code, nothing of text and comments. And the
compiler that compiles what has changed alone."""

import ctypes
import shutil
from pathlib import Path

import pytest

from . import objects
from .areas import AREAS, EQUIVALENT, ROOT, change_of, changes, drawn, quickest


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


def test_all_tests_are_run_where_no_share_is_asked_for():
    times = {f"test_{n}.py": 0.1 * (n % 7 + 1) / 3.0 for n in range(100)}
    assert set(quickest(times, 1.0)) == set(times)
    assert quickest({"a": 3.0, "b": 1.0, "c": 2.0}, 0.5) == ("b", "c")


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
