"""A program that an evidence command calls is found, or told with the package that has it."""

import pytest

from evidence.tools import PACKAGES, tool
from orchestration import InputError


@pytest.mark.parametrize("name", PACKAGES)
def test_a_program_is_found_on_the_path_or_its_package_is_named(name, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match=f"^{name} is not installed; remedy: apt install {PACKAGES[name]}, "):
        tool(name)
    (tmp_path / name).write_text("")
    (tmp_path / name).chmod(0o755)
    assert tool(name) == str(tmp_path / name)
