"""The command, as a user sees it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from fmus.build import build
from orchestration import load
from orchestration.scenario import schema
from tests.commands import orchestrate

pytestmark = pytest.mark.isolate

ROOT = Path(__file__).parents[3]


def test_a_run_ends_with_a_table_and_says_where_the_results_are(loop):
    result = orchestrate(loop.name)
    assert result.exit_code == 0
    assert "loop: ran 2 s" in result.stdout
    assert "met  the motor stops  19.1 rpm at 0 s  always < 30 rpm  10.9 rpm" in result.stdout
    assert f"results in {Path('results/loop')}" in result.stdout
    assert {p.name for p in Path("results/loop").iterdir()} >= {"signals.csv", "manifest.json", "expectations.json"}
    assert "\x1b" not in result.output, "no control codes where there is no terminal"


def test_a_failed_expectation_gives_status_1(loop):
    result = orchestrate(loop.name, "--set", "motor.speed0=4", "--quiet")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == "expectation failed: the motor stops\n"
    assert json.loads(Path("results/loop/expectations.json").read_text())["passed"] is False


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("chek", "motor.fmu"), "chek: there is no such command or scenario; did you mean 'check'?"),
        (("zzz",), "zzz: there is no such command or scenario"),
        (("loop.ymal",), "loop.ymal: there is no such file; did you mean 'loop.yaml'?"),
        (("lop.ssp",), "lop.ssp: there is no such file; did you mean 'loop.ssp'?"),
        (("lint.yaml",), "lint.yaml: there is no such file; there is only loop.yaml"),
        (
            ("motor.fmu",),
            "motor.fmu: this is an FMU, expected a scenario; remedy: orchestrate check motor.fmu --as BLOCK, "
            "or orchestrate SCENARIO --swap BLOCK=motor.fmu",
        ),
    ],
)
def test_what_is_no_scenario_is_told_from_what_it_may_be(loop, arguments, message):
    Path(".lint.yaml").write_text("{}")
    Path("loop.ssp").write_bytes(b"")
    result = orchestrate(*arguments)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", message + "\n")


def test_quiet_says_nothing_when_all_is_well(loop):
    result = orchestrate(loop.name, "--quiet")
    assert (result.exit_code, result.output) == (0, "")


@pytest.fixture
def quick_build(monkeypatch):
    """What is built is empty: nothing is compiled."""
    monkeypatch.setattr("fmus.native.package", lambda interface, folder, licence: b"")


@pytest.mark.parametrize(("options", "told"), [((), "building allocator.fmu (native) ...\n"), (("--quiet",), "")])
def test_a_run_says_which_fmu_it_builds_unless_quiet(loop, quick_build, monkeypatch, tmp_path, options, told):
    def built(block, flavour, here):
        build(["allocator"], flavour, tmp_path)
        return loop.parent / "motor.fmu"

    monkeypatch.setattr("orchestration.session.open.ensure", built)
    monkeypatch.setattr("orchestration.cli.run.noted", lambda scenario: [])  # which opens, and so builds, again here
    loop.write_text(loop.read_text().replace("fmu: motor.fmu", "fmu: plant"))
    assert orchestrate(loop.name, *options).stderr == told


def test_options_may_come_first_and_change_step_duration_and_folder(loop):
    result = orchestrate(
        "--step", "20 ms", "--duration", "1 s", "--out", "elsewhere", "--set", "motor.axis=[0, 1, 0]", loop.name
    )
    assert result.exit_code == 0
    manifest = json.loads(Path("elsewhere/manifest.json").read_text())
    assert (manifest["steps"], manifest["scenario"]["step"]) == (50, 0.02)
    assert manifest["options"] == ["--duration 1 s", "--set motor.axis=[0, 1, 0]", "--step 20 ms"]


def test_the_last_of_several_settings_counts(loop):
    orchestrate(loop.name, "--quiet", "--set", "motor.speed0=1", "--set", "motor.speed0=0.5")
    assert (
        json.loads(Path("results/loop/manifest.json").read_text())["scenario"]["blocks"]["motor"]["start"]["speed0"]
        == 0.5
    )


def test_what_a_failing_block_computed_is_kept(loop):
    result = orchestrate(loop.name, "--set", "motor.fault=1", "--set", "motor.fault_time=1.5")
    assert result.exit_code == 3
    assert "loop: failed after 1.5 s" in result.stdout
    assert len(Path("results/loop/signals.csv").read_text().splitlines()) == 1 + 16
    assert json.loads(Path("results/loop/expectations.json").read_text())["complete"] is False


def test_the_log_of_fmus_is_shown_on_request(loop):
    quiet = orchestrate(loop.name, "--set", "motor.fault=6", "--duration", 0.1)
    loud = orchestrate(loop.name, "--set", "motor.fault=6", "--duration", 0.1, "--log")
    assert "tired" not in quiet.output
    assert "motor: [warning] tired at 0" in loud.stderr


def test_remarks_are_printed(loop):
    assert (
        "note: 0.15 s is no multiple of the step, 0.1 s; the run ends at 0.2 s"
        in orchestrate(loop.name, "--duration", 0.15).stderr
    )


def test_a_shorter_run_leaves_out_what_is_expected_after_its_end_and_says_so(loop):
    loop.write_text(loop.read_text().replace("always: {below: 30 rpm}", "after: 1.5 s\n    always: {below: 5 rpm}"))
    result = orchestrate(loop.name, "--duration", "1 s")
    assert result.exit_code == 0
    assert "note: not looked at, since the run ends before 1.5 s: the motor stops" in result.stderr


def test_blocks_without_a_flavour_are_told_where_all_are_built_or_listed(tmp_path, monkeypatch):
    from fmus import build, interface

    text = interface.load("allocator").source.replace("[block]", '[block]\nflavours = ["native"]', 1)
    native = interface.parse(text)
    monkeypatch.setattr(build, "load", lambda name: native if name == "allocator" else interface.load(name))
    for command in (("build", "--out", tmp_path / "built"), ("fmus", "--copy", tmp_path / "copied")):
        result = orchestrate(command[0], "--flavour", "python", *command[1:])
        assert result.exit_code == 0, result.stderr
        assert "allocator has no flavour 'python'" in result.stdout
        assert "controller.fmu" in result.stdout
    for folder in ("built", "copied"):
        assert "allocator.fmu" not in {path.name for path in (tmp_path / folder).iterdir()}


def test_another_fmu_of_the_same_name_is_not_replaced_by_a_copy(tmp_path):
    assert orchestrate("fmus", "--copy", tmp_path).exit_code == 0
    assert orchestrate("fmus", "--copy", tmp_path).exit_code == 0, "they are the same"
    (tmp_path / "plant.fmu").write_bytes(b"of another team")
    result = orchestrate("fmus", "--copy", tmp_path)
    told = f"{tmp_path / 'plant.fmu'} is there already and differs; expected a folder without it\n"
    assert (result.exit_code, result.stderr) == (2, told)
    assert (tmp_path / "plant.fmu").read_bytes() == b"of another team"


def test_help_names_the_commands_and_the_exit_status():
    text = orchestrate("--help").output
    assert all(word in text for word in ("build", "schema", "run", "Exit status"))


def test_an_error_of_our_own_is_one_line(loop, monkeypatch):
    monkeypatch.setattr("orchestration.session.run.execute", lambda *a, **k: 1 / 0)
    result = orchestrate(loop.name)
    assert result.exit_code == 70
    assert result.stderr.startswith("internal error: ZeroDivisionError: division by zero")


def test_the_published_schema_is_that_of_the_models():
    committed = (ROOT / "docs" / "scenario.schema.json").read_text("utf-8")
    assert committed == schema.text() == orchestrate("schema").stdout, "orchestrate schema > docs/scenario.schema.json"


@pytest.fixture(scope="module")
def published():
    import jsonschema  # here, since it takes 3 s, and each run of any test would wait for it

    found = json.loads(schema.text())
    form = jsonschema.validators.validator_for(found)
    form.check_schema(found)
    return form(found)


@pytest.mark.parametrize("path", sorted((ROOT / "scenarios").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_scenarios_of_the_project_fit_the_schema(path, published):
    published.validate(load(path).source.data)


def test_a_process_starts_without_heavy_imports(loop):
    code = (
        "import sys; from orchestration.cli.main import main\n"
        "try: main(['loop.yaml', '--quiet'])\n"
        "except SystemExit: pass\n"
        "print([m for m in ('scipy', 'pandas', 'matplotlib', 'pyarrow', 'pint', 'rich') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={"PYTHONPATH": str(ROOT)}, check=True
    )
    assert done.stdout == "[]\n"
