"""Which changes a seed may draw in an area's code: operators and numbers of code, nothing of text and comments."""

from pathlib import Path

import pytest

from .areas import AREAS, EQUIVALENT, ROOT, changes


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
        text = path.read_text("utf-8")
        for begin, end, other in changes(path):
            line = text.splitlines()[text.count("\n", 0, begin)].strip()
            drawn.add(f"{path.relative_to(ROOT).as_posix()}: {text[begin:end]!r} -> {other!r}: {line}")
    assert EQUIVALENT.keys() <= drawn
