"""A scenario that extends other files."""

from __future__ import annotations

import json
import re

import pytest

from orchestration import InputError, load, run
from orchestration.scenario.source import Source
from orchestration.session.read import read

from ..wrong_inputs import SCENARIO


def test_mappings_merge_lists_and_values_replace_and_a_null_takes_out(loop):
    (loop.parent / "over.yaml").write_text(
        "extends: loop.yaml\nduration: 1 s\nblocks: {motor: {start: {speed0: 3}}}\nexpect: []\nrecord: ~\n"
    )
    data = load("over.yaml").source.data
    assert (data["name"], data["duration"], data["expect"]) == ("loop", "1 s", [])
    assert data["blocks"]["motor"] == {"fmu": "motor.fmu", "start": {"speed0": 3, "inertia": 0.5}}
    assert not {"record", "extends"} & data.keys()
    result = run("over.yaml", {"motor.inertia": 0.7})
    assert result["motor.speed"][0] == 3.0
    assert result.manifest["scenario"]["blocks"]["motor"]["start"]["inertia"] == 0.7


def test_entries_are_added_to_a_list_and_keep_their_lines(loop):
    below = load("loop.yaml").source.data["connections"]
    (loop.parent / "part.yaml").write_text("expect: {add: [{name: x, signal: motor.sped, always: {below: 1}}]}\n")
    (loop.parent / "over.yaml").write_text(
        "extends: [loop.yaml, part.yaml]\nconnections:\n  add:\n    - motor.speed -> regulator.gain\n    - a.b -> c.d\n"
    )
    with pytest.raises(InputError) as error:
        run("over.yaml")
    assert re.findall(r"(\w+\.yaml:\d+: \w+\[\d\])", str(error.value)) == [
        f"over.yaml:4: connections[{len(below) + 1}]",
        f"over.yaml:5: connections[{len(below) + 2}]",
        "part.yaml:1: expect[2]",
    ]


def test_a_connection_replaces_that_to_the_same_input_in_its_place_and_keeps_its_line(loop):
    below = load("loop.yaml").source.data["connections"]
    text = (
        "extends: loop.yaml\nconnections:\n  add: [motor.speed -> regulator.gain]\n  replace:\n    - motor.{} -> {}\n"
    )
    target = below[0].split(" -> ")[1]
    (loop.parent / "over.yaml").write_text(text.format("load", target))
    data = load("over.yaml").source.data
    assert data["connections"] == [f"motor.load -> {target}", *below[1:], "motor.speed -> regulator.gain"]
    with pytest.raises(InputError) as error:
        run("over.yaml")
    assert re.findall(r"(\w+\.yaml:\d+: \w+\[\d\])", str(error.value)) == [
        "over.yaml:5: connections[1]",
        f"over.yaml:3: connections[{len(below) + 1}]",
    ]


def test_a_connection_to_an_input_that_is_not_connected_replaces_none(loop):
    (loop.parent / "over.yaml").write_text(
        "extends: loop.yaml\nconnections:\n  replace: [motor.speed -> regulator.sped]\n"
    )
    with pytest.raises(
        InputError,
        match=r"over\.yaml:3: connections\.replace\[1\]: 'motor\.speed -> regulator\.sped': there is no "
        r"connection to this "
        r"input to replace; did you mean 'regulator\.speed'\?",
    ):
        load("over.yaml")


def test_two_connections_that_replace_that_to_one_input_are_refused(loop):
    first = load("loop.yaml").source.data["connections"][0]
    (loop.parent / "over.yaml").write_text(
        f"extends: loop.yaml\nconnections:\n  replace:\n    - {first}\n    - {first}\n"
    )
    with pytest.raises(
        InputError, match=r"over\.yaml:5: connections\.replace\[2\]: .* the connection to this input is replaced twice"
    ):
        load("over.yaml")


@pytest.mark.parametrize("entry", ["motor.speed regulator.speed", "{motor.speed: regulator.speed}", "3"])
def test_what_is_no_connection_replaces_none(loop, entry):
    (loop.parent / "over.yaml").write_text(f"extends: loop.yaml\nconnections:\n  replace:\n    - {entry}\n")
    with pytest.raises(
        InputError, match=r"over\.yaml:4: connections\.replace\[1\]: expected 'block\.output -> block\.input', found "
    ):
        load("over.yaml")


@pytest.mark.parametrize(
    "change",
    ["expect: {replace: []}", "connections: {}", "connections: {replace: a.b -> c.d}", "delays: {add: [a.b]}"],
)
def test_only_connections_are_replaced_by_a_list_of_them_and_only_a_list_below_is_added_to(loop, change):
    (loop.parent / "over.yaml").write_text(f"extends: loop.yaml\n{change}\n")
    with pytest.raises(InputError, match=r"over\.yaml:2: \w+: expected a list"):
        load("over.yaml")


def test_later_files_go_before_earlier_ones_and_a_value_of_several_names_is_replaced_as_a_whole(loop):
    (loop.parent / "a.yaml").write_text("blocks: {motor: {start: {J: {axis: [1, 0, 0], angle: 1}, inertia: 1}}}\n")
    (loop.parent / "b.yaml").write_text("blocks: {motor: {start: {J: {quaternion: [1, 0, 0, 0]}}}}\n")
    (loop.parent / "over.yaml").write_text("extends: [loop.yaml, a.yaml, b.yaml]\n")
    assert load("over.yaml").blocks["motor"].start == {
        "speed0": "2 rad/s",
        "inertia": 1,
        "J": {"quaternion": [1, 0, 0, 0]},
    }


def test_a_file_that_changes_is_read_anew_and_what_was_read_is_the_readers_own(loop):
    folder = loop.parent
    (folder / "below.yaml").write_text("duration: 1 s\nextends: loop.yaml\n")
    (folder / "over.yaml").write_text("extends: below.yaml\n")
    load("over.yaml").source.data["duration"] = "9 s"
    assert load("over.yaml").duration == 1.0
    (folder / "below.yaml").write_text("duration: 2 s\nextends: loop.yaml\n")
    assert load("over.yaml").duration == 2.0
    (folder / "below.yaml").unlink()
    with pytest.raises(InputError, match=r"over\.yaml:1: extends: below\.yaml: there is no such file"):
        load("over.yaml")


def test_an_error_names_the_file_and_the_line_that_it_is_in(loop):
    (loop.parent / "part.yaml").write_text("# a part\nblocks:\n  motor:\n    start:\n      inertia: 50\n")
    (loop.parent / "over.yaml").write_text(
        "extends: [loop.yaml, part.yaml]\nblocks:\n  regulator: {start: {gian: 1}}\n"
    )
    with pytest.raises(InputError) as error:
        run("over.yaml")
    assert "part.yaml:5: blocks.motor.start.inertia: expected at most 10 kg.m2" in str(error.value)
    assert "over.yaml:3: blocks.regulator.start: regulator has no parameter 'gian'" in str(error.value)


def test_a_misspelt_key_of_a_part_is_found_there(loop):
    (loop.parent / "part.yaml").write_text("\nshard: {inertia: 1}\n")
    (loop.parent / "over.yaml").write_text("extends: [loop.yaml, part.yaml]\n")
    with pytest.raises(InputError, match=r"part.yaml:2: unknown key 'shard'; did you mean 'shared'\?"):
        load("over.yaml")


def test_paths_start_at_the_folder_of_the_file_that_names_them(loop):
    (loop.parent / "deep" / "er").mkdir(parents=True)
    (loop.parent / "deep" / "base.yaml").write_text(SCENARIO.replace("fmu: ", "fmu: ../"))
    (loop.parent / "deep" / "er" / "over.yaml").write_text("extends: ../base.yaml\nname: over\n")
    source = load("deep/er/over.yaml").source
    assert source.data["blocks"]["motor"]["fmu"] == "../../motor.fmu"
    assert run("deep/er/over.yaml").passed


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (
            {"over.yaml": "extends: over.yaml\n"},
            "over.yaml:1: extends: the files extend each other in a circle: over.yaml",
        ),
        (
            {"over.yaml": "extends: [b.yaml]\n", "b.yaml": "name: b\nextends: over.yaml\n"},
            "b.yaml:2: extends: the files extend each other in a circle: over.yaml -> b.yaml -> over.yaml",
        ),
        (
            {"over.yaml": "name: x\nextends:\n  - lop.yaml\n"},
            "over.yaml:3: extends[1]: lop.yaml: there is no such file; did you mean 'loop.yaml'?",
        ),
        (
            {"over.yaml": "name: x\nextends: nosuch.yaml\n", "sug.yaml": "name: y\n"},
            "over.yaml:2: extends: nosuch.yaml: there is no such file; there are loop.yaml, over.yaml, sug.yaml",
        ),
        (
            {"over.yaml": 'name: x\nextends: "a\\0b.yaml"\n'},
            "over.yaml:2: extends: 'a\\x00b.yaml' is no path: embedded null byte",
        ),
        (
            {"over.yaml": "name: x\nextends: b.yaml\n", "b.yaml": "step: 1\nstep: 2\n"},
            "b.yaml:2: 'step' is given twice; first in line 1",
        ),
        ({"over.yaml": "extends: [3]\n"}, "over.yaml:1: extends: expected the paths of files, found 3"),
        ({"over.yaml": "extends: b.yaml\n", "b.yaml": "- a\n"}, "b.yaml:1: expected keys such as 'shared' or 'blocks'"),
    ],
)
def test_what_cannot_be_extended_is_refused(loop, files, message):
    for name, text in files.items():
        (loop.parent / name).write_text(text)
    with pytest.raises(InputError) as error:
        load("over.yaml")
    assert str(error.value).startswith(message)


def test_a_scenario_given_as_data_extends_files_too(loop):
    assert run({"extends": "loop.yaml", "duration": 0.5}).time[-1] == 0.5


def test_what_is_neither_a_file_nor_data_extends_nothing(loop):
    source = Source({**load("loop.yaml").source.data, "extends": ["secret.yaml"]}, "archive.ssp")
    with pytest.raises(InputError, match="archive.ssp: extends: only a file in YAML"):
        load(source)


def test_times_are_counted_in_what_the_cycle_names(loop):
    text = SCENARIO.replace("duration: 2 s", "duration: 2 turns").replace("signal:", "after: 0.5 turn\n    signal:")
    loop.write_text(text + "cycle: {name: turns, period: 0.25 s}\n")
    scenario = load("loop.yaml", {})
    assert (scenario.duration, scenario.expect[0].after) == (0.5, 0.125)
    assert load("loop.yaml", {"duration": "4 turns"}).duration == 1.0
    loop.write_text(text)
    with pytest.raises(InputError, match="loop.yaml:3: duration: .*turns"):
        load("loop.yaml")
    loop.write_text(text + "cycle: {name: turns, period: 2 turns}\n")
    with pytest.raises(InputError, match="loop.yaml:22: cycle.period"):
        load("loop.yaml")


def test_the_manifest_has_the_scenario_as_resolved_which_runs_as_it_stands(loop):
    loop.write_text(
        SCENARIO.replace("inertia: 0.5", "speed0: 1").replace("speed0: 2 rad/s\n", "") + "shared: {inertia: 0.5}\n"
    )
    first = run("loop.yaml")
    resolved = json.loads(json.dumps(first.manifest["scenario"]))
    assert "shared" not in resolved
    assert resolved["blocks"]["motor"]["start"]["inertia"] == 0.5
    assert (run(resolved)["motor.speed"] == first["motor.speed"]).all()


def test_a_law_takes_the_place_of_an_fmu_with_its_ports_and_start_values(tmp_path):
    (tmp_path / "parts").mkdir()
    below = {"fmu": "controller_planned", "flavour": "native", "every": 5, "start": {"control_period": "0.5 s"}}
    (tmp_path / "loop.yaml").write_text(
        json.dumps({"blocks": {"controller": below, "theirs": {"fmu": "a/theirs.fmu"}}})
    )
    laws = {"controller": {"python": "my_law.py"}, "theirs": {"python": "my_law.py", "interface": "allocator"}}
    (tmp_path / "parts" / "own.yaml").write_text(json.dumps({"extends": "../loop.yaml", "blocks": laws}))
    (tmp_path / "top.yaml").write_text(json.dumps({"extends": "parts/own.yaml", "name": "top"}))
    blocks = read(tmp_path / "top.yaml").data["blocks"]
    assert blocks["controller"] == {
        "every": 5,
        "start": {"control_period": "0.5 s"},
        "interface": "controller_planned",
        "python": "parts/my_law.py",
    }
    assert blocks["theirs"] == {"python": "parts/my_law.py", "interface": "allocator"}


@pytest.mark.parametrize(
    ("path", "expected"), [("../plant", "./plant"), ("a.fmu", "part/a.fmu"), ("../b.fmu", "b.fmu")]
)
def test_a_path_beside_the_file_that_extends_another_is_not_taken_for_a_block_of_ours(path, expected, tmp_path):
    (tmp_path / "part").mkdir()
    (tmp_path / "part" / "part.yaml").write_text(f"name: n\nstep: 1\nduration: 1\nblocks: {{m: {{fmu: {path}}}}}\n")
    (tmp_path / "over.yaml").write_text("extends: part/part.yaml\n")
    assert load(tmp_path / "over.yaml").source.data["blocks"]["m"]["fmu"] == expected
