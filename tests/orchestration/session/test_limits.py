"""Which FMUs get a process of their own, and what they may take."""

from __future__ import annotations

import shutil

import pytest

from orchestration import InputError, load
from orchestration.instances.process import Limits
from orchestration.session.limits import MEMORY, TIMEOUT, limits
from orchestration.session.open import open_scenario

from .. import fmus


def test_only_laws_and_fmus_given_by_a_path_are_isolated_unless_the_scenario_says_so():
    blocks = {
        "ours": {"fmu": "plant"},
        "ours_apart": {"fmu": "plant", "isolation": "process"},
        "theirs": {"fmu": "vendor.fmu", "timeout": "5 min", "memory": "1.5 GiB"},
        "law": {"python": "law.py", "timeout": 5},
        "trusted": {"fmu": "vendor.fmu", "isolation": "none"},
    }
    data = {"name": "x", "step": 1, "duration": 1, "blocks": blocks}
    found = {name: limits(load(data), name) for name in blocks}
    assert found["ours"] is found["trusted"] is None
    assert found["theirs"] == Limits(300.0, 3 * 2**29)
    assert found["law"].timeout == 5.0
    assert found["ours_apart"].timeout == TIMEOUT
    assert found["ours_apart"].memory <= MEMORY
    assert limits(load({**data, "isolation": "process"}), "ours") is not None


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            {"isolation": "none", "timeout": 5},
            "blocks.a.timeout: only an FMU or a law in a process of its own",
        ),
        (
            {"isolation": "none", "memory": "1 GB"},
            "blocks.a.memory: only an FMU or a law in a process of its own",
        ),
        ({"timeout": 0}, "blocks.a.timeout: expected a time above zero"),
        ({"memory": "much"}, "blocks.a.memory: expected an amount of memory such as '2 GB', found 'much'"),
        ({"memory": "2 kB"}, "blocks.a.memory: expected at least 1 MB, found 2000 bytes"),
        ({"isolation": "thread"}, "blocks.a.isolation: expected 'process' or 'none', found 'thread'"),
    ],
)
def test_wrong_limits_are_refused(entry, message):
    data = {"name": "x", "step": 1, "duration": 1, "blocks": {"a": {"fmu": "a.fmu", **entry}}}
    with pytest.raises(InputError) as info:
        limits(load(data), "a")
    assert message in str(info.value)


def test_an_fmu_that_can_have_one_instance_in_a_process_has_no_second_there(tmp_path, monkeypatch):
    """Nor has a copy of it under another name; in a process of its own, or beside another FMU, it may run."""
    monkeypatch.chdir(tmp_path)
    for name, inside in (("lone", "lone"), ("copy", "lone"), ("other", "other")):
        xml = fmus.description("motor").replace(
            "modelIdentifier", 'canBeInstantiatedOnlyOncePerProcess="true" modelIdentifier'
        )
        fmus.write(tmp_path / f"{name}.fmu", xml.replace('modelName="motor"', f'modelName="{inside}"'), fmus.library())
    shutil.copy("lone.fmu", "copy.fmu")

    fed = {"voltage": 0}

    def opened(fmu, isolation="none"):
        blocks = {
            "a": {"fmu": "lone.fmu", "isolation": "none", "start": fed},
            "b": {"fmu": fmu, "isolation": isolation, "start": fed},
        }
        return open_scenario(load({"name": "x", "step": 0.1, "duration": 1, "blocks": blocks}))

    for fmu in ("lone.fmu", "copy.fmu"):
        with pytest.raises(InputError) as info:
            opened(fmu)
        assert str(info.value).endswith(
            f"blocks.b.fmu: {fmu} can have one instance in a process (canBeInstantiatedOnlyOncePerProcess), and a "
            "is one "
            "in this process, too; remedy: isolation: process"
        )
    assert set(opened("lone.fmu", "process").fmus) == set(opened("other.fmu").fmus) == {"a", "b"}
