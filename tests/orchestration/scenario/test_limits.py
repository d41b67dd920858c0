"""Files that are no scenario, or more than one: refused soon, and without a word of what they hold."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from orchestration import InputError, load
from orchestration.scenario import mapping
from orchestration.scenario.text import parse

ROOT = Path(__file__).parents[3]


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def bomb(folder: Path) -> Path:
    """Nine files, each of which extends the next ten times: ten to the eighth."""
    for number in range(8):
        names = ", ".join([f"{number + 1}.yaml"] * 10)
        write(folder / f"{number}.yaml", f"extends: [{names}]\n")
    write(folder / "8.yaml", "step: 1\n")
    return folder / "0.yaml"


def chain(folder: Path) -> Path:
    for number in range(2000):
        write(folder / f"{number}.yaml", f"extends: {number + 1}.yaml\n")
    write(folder / "2000.yaml", "step: 1\n")
    return folder / "0.yaml"


def sparse(folder: Path) -> Path:
    with (folder / "sparse.yaml").open("wb") as file:
        file.truncate(4 * 10**9)
    return folder / "sparse.yaml"


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe.yaml")
    return folder / "pipe.yaml"


@pytest.mark.timeout(20)
@pytest.mark.parametrize(
    ("made", "told"),
    [
        (bomb, "more than 100 files are extended"),
        (chain, r"\d+\.yaml:1: extends: more than 100 files are extended, the most that are laid together"),
        (lambda folder: write(folder / "list.yaml", "a: [" + "1," * 3_000_000 + "1]"), "too many entries"),
        (sparse, r"sparse\.yaml holds 4e\+03 MB; expected a file of YAML, of at most 16 MB"),
        (pipe, r"pipe\.yaml is no regular file"),
        (lambda folder: Path("/dev/zero"), "/dev/zero is no regular file"),
    ],
)
def test_what_would_take_for_ever_is_refused_soon(
    made: Callable[[Path], Path], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = made(tmp_path)
    with pytest.raises(InputError, match=told):
        load(path)
    with pytest.raises(InputError):
        mapping.load(path)
    with pytest.raises(InputError, match=told):
        load({"name": "a", "extends": str(path)})


def test_a_file_that_is_no_scenario_is_not_printed(tmp_path: Path) -> None:
    secret = write(tmp_path / "shadow", "root:$6$secret:19000:0:99999\nbin:*:1\n")
    for read in (load, mapping.load, lambda path: load({"name": "a", "extends": str(path)})):
        with pytest.raises(InputError, match="shadow:1: expected keys such as .*, found text") as info:
            read(secret)
        assert "secret" not in str(info.value)


@pytest.mark.parametrize("text", ["password: *secret\n", "- !secret x\n", "&secret a: 1\nb: *secrets\n", "%secret x\n"])
def test_what_is_no_yaml_is_not_printed(text: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="hidden") as info:
        load(write(tmp_path / "hidden", text))
    assert "secret" not in str(info.value)


@pytest.mark.parametrize("text", ["root:$6$secret:19000:0:99999:7:::\nbin:*:1:::\n", '{"secrets": {"secret": "x"}}\n'])
def test_a_file_of_keys_that_no_scenario_has_is_not_printed_and_a_misspelt_key_is(text: str, tmp_path: Path) -> None:
    secret = write(tmp_path / "shadow", text)
    over = {"name": "a", "extends": [str(ROOT / "scenarios" / "minimal.yaml"), str(secret)]}
    for read in (load, mapping.load, lambda path: load({"name": "a", "extends": str(path)}), lambda path: load(over)):
        with pytest.raises(InputError, match="shadow: expected keys such as .*, found none") as info:
            read(secret)
        assert "secret" not in str(info.value).replace(str(tmp_path), "")
    with pytest.raises(InputError, match="shadow:1: unknown key 'durration'; did you mean 'duration'?") as info:
        load({"name": "a", "extends": str(write(secret, "durration: 3\nsecret: 3\n"))})
    assert "secret" not in str(info.value).replace(str(tmp_path), "")


def test_a_colon_within_text_is_told_with_the_remedy(tmp_path: Path) -> None:
    path = write(tmp_path / "a.yaml", "name: a\ndescription: what: it shows\n")
    with pytest.raises(InputError, match=r"a\.yaml:2: no valid YAML: .*; remedy: quote a text that holds a colon"):
        load(path)


@pytest.mark.parametrize(
    "text", ["name: a\nshared: {x: [1, 2] mm}\n", "name: a\nshared:\n  x: [1, 2] mm\n", "[1, 2] mm"]
)
def test_a_unit_after_a_list_is_told_with_the_remedy(text: str) -> None:
    with pytest.raises(InputError, match=r"no valid YAML: text behind a list; remedy: a unit stands at each number"):
        parse(text)
    for other in ("x: [1, 2]\nmm\n", "x: [1, 2]]\n"):  # what is wrong is no unit of the list
        with pytest.raises(InputError) as caught:
            parse(other)
        assert "behind a list" not in str(caught.value)
