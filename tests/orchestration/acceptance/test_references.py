"""The reference data that an FMU carries (FMI-LS-REF): played, found wrong where it is wrong, and read in all its
forms.
"""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from fmus.build import FLAVOURS, blocks_of, ensure
from fmus.contents.references import FOLDER
from orchestration.acceptance import experiments, references
from orchestration.acceptance.vector import record, scenario_of
from orchestration.cli.main import main
from orchestration.fmu.archive import open_fmu
from tests.commands import orchestrate

from .. import fmus

OURS = [(block, flavour) for flavour in FLAVOURS for block in blocks_of(flavour)]
NAMESPACE = (
    'xmlns:l="http://fmi-standard.org/fmi-ls-manifest" l:fmi-ls-name="org.fmi-standard.fmi-ls-ref" '
    'l:fmi-ls-version="1.0.0-beta.1"'
)
EXPERIMENT = """\
<Experiments name="all">
<Experiment name="feedthrough" startTime="0" stopTime="0.4" stepSize="0.1">
<Parameters source="p.ssv"/>
<Stimuli source="in.csv"/>
<References source="out.csv"/>
</Experiment>
</Experiments>
"""
MANIFEST = f"""\
<fmiReferences {NAMESPACE}>
<Related type="application/x-ma-hs-experiments" source="all.exp" role="experiment"/>
</fmiReferences>
"""
GAIN = """\
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="p">
<ssv:Parameters><ssv:Parameter name="gain"><ssv:Real value="-2"/></ssv:Parameter></ssv:Parameters>
</ssv:ParameterSet>
"""
SPEED = (1.0, 2.0, 4.0, 8.0, 16.0)
VOLTAGE = (-2.0, -2.0, -4.0, -8.0, -16.0)
"""V = -2 speed, the speed being set before the step."""


def table(name: str, values: tuple[float, ...]) -> str:
    return f"time,{name}\n" + "".join(f"{0.1 * i:.1f},{value}\n" for i, value in enumerate(values))


def regulator(folder: Path, **changed: str) -> Path:
    """regulator.fmu with reference data; a file is given by its name with an underscore for the dot, None leaves it
    out.
    """
    xml = changed.pop("description", None) or fmus.description("regulator")
    path = fmus.write(folder / "regulator.fmu", xml, fmus.library())
    files = {"fmi-ls-manifest.xml": MANIFEST, "all.exp": EXPERIMENT, "p.ssv": GAIN}
    files |= {"in.csv": table("speed", SPEED), "out.csv": table("voltage", VOLTAGE)}
    files |= {
        name.replace("manifest_xml", "fmi-ls-manifest_xml").replace("_", "."): text for name, text in changed.items()
    }
    with zipfile.ZipFile(path, "a") as archive:
        for name, text in files.items():
            if text is not None:
                archive.writestr(f"{FOLDER}/{name}", text)
    return path


def played(path: Path, tolerance: float = 1e-9):
    """Level and text of what is found of the reference data, in this process."""
    fmu = open_fmu(path)
    found, notes = experiments.read(path, fmu.model, fmu.description.defaultExperiment)
    findings = [f for one in found for f in references.play(path, fmu.model, one, tolerance, "none")]
    return [(f.level, f.text) for f in findings], notes


@pytest.mark.parametrize(("block", "flavour"), OURS)
def test_each_of_our_fmus_carries_data_of_all_its_outputs_and_reproduces_them(block, flavour):
    path = ensure(block, flavour)
    fmu = open_fmu(path)
    ((experiment,), notes) = experiments.read(path, fmu.model, None)
    assert notes == []
    outputs = {e for v in fmu.model.of("output") if v.type != "string" for e in v.elements}
    assert set(experiment.references.columns) == outputs
    assert experiment.stimuli is not None
    moving = [v for v in experiment.references.columns.values() if np.ptp(v) > 0.0]
    assert len(moving) > 0.3 * len(outputs), "the data show that the block works"
    findings = references.play(path, fmu.model, experiment, 0.0, "none")
    assert [f.level for f in findings] == ["ok"], "\n".join(f.text for f in findings)


def test_our_data_take_little_room():
    for block, flavour in OURS:
        with zipfile.ZipFile(ensure(block, flavour)) as archive:
            assert sum(e.compress_size for e in archive.infolist() if e.filename.startswith(FOLDER)) < 50_000
            assert "documentation/fmi-ls-ref.txt" in archive.namelist()


def test_a_command_of_an_fmu_writes_what_its_fmu_carries(tmp_path):
    """But for the last digits: the same sources and the same run."""
    assert orchestrate("reference", "allocator", "--out", tmp_path).exit_code == 0
    with zipfile.ZipFile(ensure("allocator")) as archive:
        for path in tmp_path.iterdir():
            assert path.read_bytes() == archive.read(f"{FOLDER}/{path.name}"), path.name


def test_that_the_data_have_only_the_beginning_of_the_vector_is_told(tmp_path):
    record(scenario_of("allocator"), "allocator", tmp_path / "vector")
    lines = len((tmp_path / "vector" / "vector.csv").read_text().splitlines()) - 1
    result = orchestrate("reference", ensure("allocator"), "--vector", tmp_path / "vector", "--out", tmp_path / "data")
    told = f"vector.csv to {0.1 * (lines - 1):.10g} s the first 61 instants, to 6 s"
    assert (result.exit_code, told in " ".join(result.stderr.split())) == (0, lines > 61), result.stderr


def test_a_folder_that_cannot_be_written_is_told_before_a_run_and_a_file_in_it_with_its_own_status(
    tmp_path, monkeypatch
):
    (tmp_path / "file").touch()
    (tmp_path / "folder" / "outputs.csv").mkdir(parents=True)
    result = orchestrate("reference", "allocator", "--out", tmp_path / "folder")
    assert (result.exit_code, "outputs.csv cannot be written: it is a folder" in result.stderr) == (4, True)
    monkeypatch.setattr("orchestration.cli.reference.ensure", lambda *a: pytest.fail("it was built"))
    result = orchestrate("reference", "allocator", "--out", tmp_path / "file")
    assert (result.exit_code, f"{tmp_path / 'file'} is a file" in result.stderr) == (2, True)


def test_inputs_are_set_before_the_step_that_begins_at_their_time(tmp_path):
    findings, notes = played(regulator(tmp_path))
    assert (findings, notes) == ([("ok", "feedthrough: 1 outputs as expected over 0.4 s, to the last bit")], [])


def test_check_plays_what_a_vendors_fmu_carries_and_a_wrong_output_fails_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = regulator(tmp_path)
    result = orchestrate("check", path, "--as", path)
    assert result.exit_code == 0, result.output
    assert "reference    feedthrough: 1 outputs as expected over 0.4 s" in result.stdout
    wrong = regulator(tmp_path, out_csv=table("voltage", (*VOLTAGE[:3], -8.5, -16.0)))
    result = orchestrate("check", wrong, "--as", wrong, "--json")
    assert result.exit_code == 1
    (finding,) = [f for f in json.loads(result.stdout)["findings"] if f["topic"] == "reference"]
    assert finding["text"] == "feedthrough: voltage differs by 0.5 V at 0.3 s; expected at most 1.6e-05"
    assert orchestrate("check", wrong, "--as", wrong, "--no-play").exit_code == 0


def test_an_fmu_that_fails_on_its_own_data_is_a_finding(tmp_path):
    path = regulator(tmp_path, p_ssv=GAIN.replace('"gain"><ssv:Real value="-2"', '"fault"><ssv:Integer value="5"'))
    ((level, text),), _ = played(path)
    assert level == "error"
    assert "the gain is refused" in text


def test_a_tolerance_is_that_of_the_signal_or_else_of_the_experiment_or_else_the_one_asked_for(tmp_path):
    near = table("voltage", (*VOLTAGE[:4], -16.1))
    assert played(regulator(tmp_path, out_csv=near), 0.01)[0][0][0] == "ok"
    assert played(regulator(tmp_path, out_csv=near), 0.005)[0][0][0] == "error"
    of_all = EXPERIMENT.replace('stepSize="0.1"', 'stepSize="0.1" tolerance="0.01"')
    assert played(regulator(tmp_path, out_csv=near, all_exp=of_all), 0.0)[0][0][0] == "ok"
    note = (
        '<Annotations><Annotation type="attitude-cosim"><Tolerance name="voltage" '
        'absolute="{}"/></Annotation></Annotations>'
    )
    for absolute, level in ((0.11, "ok"), (0.09, "error")):
        own = of_all.replace('"out.csv"/>', f'"out.csv">{note.format(absolute)}</References>')
        assert played(regulator(tmp_path, out_csv=near, all_exp=own), 0.0)[0][0][0] == level


ENDS = """\
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="p">
<ssv:Parameters><ssv:Parameter name="gain"><ssv:Real value="-2"/></ssv:Parameter>
<ssv:Parameter name="fault"><ssv:Integer value="{}"/></ssv:Parameter>
<ssv:Parameter name="fault_time"><ssv:Real value="0.25"/></ssv:Parameter></ssv:Parameters>
</ssv:ParameterSet>
"""


def test_an_fmu_that_ends_the_simulation_where_its_data_end_is_as_expected(tmp_path):
    """As Stair of the Reference FMUs does, after ten seconds. One that fails there, or ends sooner, is wrong."""
    until = {"out_csv": table("voltage", VOLTAGE[:4]), "p_ssv": ENDS.format(4)}
    to_its_end = {**until, "out_csv": table("voltage", VOLTAGE[:5])}
    told = "feedthrough: 1 outputs as expected over 0.3 s, to the last bit; it ends the simulation after 0.3 s"
    assert played(regulator(tmp_path, **until))[0] == [("ok", told.partition("; it")[0])]
    assert played(regulator(tmp_path, **to_its_end))[0] == [("ok", told)], "the step that it discards gives nothing"
    longer = {**until, "out_csv": table("voltage", (*VOLTAGE, -16.0))}
    longer["all_exp"] = EXPERIMENT.replace("0.4", "0.5")
    told = "feedthrough: it ends the simulation after 0.3 s; its reference data go on to 0.5 s"
    assert played(regulator(tmp_path, **longer))[0] == [("error", told)]
    ((level, text),), _ = played(regulator(tmp_path, **{**to_its_end, "p_ssv": ENDS.format(1)}))
    assert (level, "gave status error" in text) == ("error", True)


def test_text_among_the_data_is_left_out_and_of_two_rows_at_an_event_either_will_do(tmp_path):
    """As in Feedthrough of the Reference FMUs."""
    rows = "time,voltage,name\n0,-2,a\n0.1,-2,b\n0.2,-2,b\n0.2,-4,c\n0.3,-8,d\n0.4,-16,e\n"
    named = (
        fmus.description("regulator")
        .replace(
            '<ScalarVariable name="samples[1]"',
            '<ScalarVariable name="name" valueReference="0" causality="output" '
            'variability="discrete"><String/></ScalarVariable>'
            '\n<ScalarVariable name="samples[1]"',
        )
        .replace('index="7"', 'index="9"')
    )
    path = regulator(tmp_path, out_csv=rows, description=named)
    told = "feedthrough: 1 outputs as expected over 0.4 s, to the last bit; name is left out"
    assert played(path)[0] == [("ok", told)]
    rows = rows.replace("0.2,-4,c", "0.2,-3,c").replace("0.2,-2,b", "0.2,-1,b")
    assert played(regulator(tmp_path, out_csv=rows, description=named))[0][0][0] == "error"


def test_other_drafts_are_read(tmp_path):
    """Experiments in the manifest, settings in an element of their own, a coarser table, and a result of the default
    experiment.
    """
    ok = "feedthrough: 1 outputs as expected over 0.4 s, to the last bit"
    inside = MANIFEST.replace("<Related", EXPERIMENT.partition("\n")[2].removesuffix("</Experiments>\n") + "<Related")
    inside = inside.replace('role="experiment"', 'role="other"')
    assert played(regulator(tmp_path, manifest_xml=inside, all_exp=None))[0] == [("ok", ok)]
    settings = 'startTime="0" stopTime="0.4" stepSize="0.1"'
    newer = EXPERIMENT.replace(f" {settings}>", f"><TransientSimulation {settings}/>")
    assert played(regulator(tmp_path, all_exp=newer))[0] == [("ok", ok)]
    coarse = "time,speed\n0,1\n0.2,3\n0.4,5\n"  # a line in between
    assert played(regulator(tmp_path, in_csv=coarse, out_csv=table("voltage", (-2, -2, -4, -6, -8))))[0] == [("ok", ok)]
    alone = MANIFEST.replace("application/x-ma-hs-experiments", "text/csv").replace(
        '"all.exp" role="experiment"', '"out.csv" role="result"'
    )
    held = table('"samples[1]"', (0.0,) * 5)
    ((level, text),), _ = played(regulator(tmp_path, manifest_xml=alone, out_csv=held))
    assert (level, text.partition(":")[0]) == ("ok", "default experiment")


def test_a_header_names_an_element_with_or_without_a_comma(tmp_path):
    plant = open_fmu(ensure("plant"))
    reader = experiments._Reader(Path("x.fmu"), None, plant.model, None)
    assert reader._element("t.csv", 1, "R_NB[2][3]", "output") == reader._element("t.csv", 1, "R_NB[2,3]", "output")


MALFORMED = [
    ({"manifest_xml": "<fmiReferences>"}, "fmi-ls-manifest.xml:1: "),
    ({"manifest_xml": "<other/>"}, "fmi-ls-manifest.xml:1: expected the element fmiReferences, found other"),
    (
        {"manifest_xml": MANIFEST.replace(' role="experiment"', "")},
        "fmi-ls-manifest.xml:2: Related has no attribute role",
    ),
    (
        {"manifest_xml": MANIFEST.replace("all.exp", "../../../all.exp")},
        "fmi-ls-manifest.xml:2: '../../../all.exp' leads out of the FMU",
    ),
    (
        {"manifest_xml": MANIFEST.replace('role="', 'checksum="00" role="')},
        "fmi-ls-manifest.xml:2: extra/org.fmi-standard.fmi-ls-ref/all.exp was changed",
    ),
    (
        {"manifest_xml": MANIFEST.replace('role="', 'checksum="0" checksumType="MD5" role="')},
        "fmi-ls-manifest.xml:2: checksumType 'MD5'",
    ),
    ({"all_exp": "<!DOCTYPE a>" + EXPERIMENT}, "all.exp: it has a DOCTYPE"),
    (
        {"all_exp": EXPERIMENT.replace('stepSize="0.1"', 'stepSize="fast"')},
        "all.exp:2: stepSize: expected a finite number, 0 or more, found 'fast'",
    ),
    (
        {"all_exp": EXPERIMENT.replace('stepSize="0.1"', 'stepSize="0"')},
        "all.exp:5: expected a step above 0 and up to the stop time, found 0 s",
    ),
    ({"out_csv": "t,voltage\n0,1\n1,1\n"}, "out.csv:1: expected a column 'time'"),
    ({"out_csv": "time,voltage\n0,1\n1\n"}, "out.csv:3: expected 2 values, found 1"),
    ({"out_csv": "time,voltage\n0,1\n1,high\n"}, "out.csv:3: could not convert string to float: 'high'"),
    ({"out_csv": "time,voltage\n0,1\n1,nan\n"}, "out.csv:3: expected finite numbers"),
    ({"out_csv": "time,voltage\n0,1\n0,1\n"}, "out.csv:2: expected times that begin at 0 and rise"),
    ({"out_csv": table("volltage", VOLTAGE)}, "out.csv:1: the FMU has no variable 'volltage'; did you mean 'voltage'?"),
    ({"in_csv": table("voltage", SPEED)}, "in.csv:1: voltage is no input; its causality is output"),
    ({"p_ssv": GAIN.replace('"gain"', '"gane"')}, "p.ssv: the FMU has no variable 'gane'; did you mean 'gain'?"),
    ({"p_ssv": GAIN.replace("value=", "worth=")}, "is not valid by the schema of SSP 1.0"),
]


@pytest.mark.parametrize(("changes", "message"), MALFORMED, ids=[message[:40] for _, message in MALFORMED])
def test_malformed_data_are_an_error_with_file_and_line(changes, message, tmp_path):
    path = regulator(tmp_path, **changes)
    findings: list = []
    fmu = open_fmu(path)
    references.look(path, fmu.model, fmu.description.defaultExperiment, 1e-6, findings)
    assert [f.level for f in findings] == ["error"]
    assert message in findings[0].text


@pytest.mark.parametrize(
    ("changes", "note"),
    [
        (
            {"all_exp": EXPERIMENT.replace('"out.csv"', '"out.hdf5" type="application/hdf5"')},
            "out.hdf5 is of the type 'application/hdf5'",
        ),
        (
            {"all_exp": EXPERIMENT.replace("<Parameters", "<SteadyState/><Parameters")},
            "a SteadyState; only simulations over time",
        ),
        (
            {"all_exp": EXPERIMENT.replace('startTime="0"', 'startTime="2"')},
            "it starts at 2 s; only experiments from 0 s",
        ),
        ({"all_exp": EXPERIMENT.replace("out.csv", "https://example.org/out.csv")}, "stands outside the FMU"),
        ({"all_exp": EXPERIMENT.replace('stepSize="0.1"', 'stepSize="1e-9"')}, "4e+08 steps; at most 1e+06 are played"),
        ({"out_csv": None}, "the FMU does not hold extra/org.fmi-standard.fmi-ls-ref/out.csv"),
        ({"all_exp": None}, "the FMU does not hold extra/org.fmi-standard.fmi-ls-ref/all.exp"),
    ],
)
def test_what_cannot_be_played_here_is_told(changes, note, tmp_path):
    """FMI-LS-REF: an importer is to be prepared for files that other tools have lost."""
    findings, notes = played(regulator(tmp_path, **changes))
    assert findings == []
    assert [note in text for text in notes] == [True]


def test_the_manifest_is_of_the_draft_that_it_names():
    """Names, roles and types of FMI-LS-REF 1.0.0-beta.1, and no attribute that its schema does not know."""
    from lxml import etree

    with zipfile.ZipFile(ensure("plant")) as archive:
        root = etree.fromstring(archive.read(f"{FOLDER}/fmi-ls-manifest.xml"))
        space = "{http://fmi-standard.org/fmi-ls-manifest}"
        assert (root.tag, root.get(f"{space}fmi-ls-name")) == ("fmiReferences", "org.fmi-standard.fmi-ls-ref")
        assert root.get(f"{space}fmi-ls-version") == "1.0.0-beta.1"
        assert (
            root.get(f"{space}fmi-ls-description")
            == "Layered Standard providing information on related files included in an FMU."
        )
        listed = {entry.get("source"): entry for entry in root.findall("Related")}
        assert {f"{FOLDER}/{name}" for name in (*listed, "fmi-ls-manifest.xml")} == {
            n for n in archive.namelist() if n.startswith("extra/")
        }
        assert listed["smoke-test.exp"].get("role") == "experiment/smoke-test"
        assert listed["smoke-test.exp"].get("type") == "application/x-ma-hs-experiments"
        known = {"type", "source", "role", "description"}
        assert all(set(entry.attrib) <= known for entry in listed.values())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("reference", "alocator"), "there is no block 'alocator'; did you mean 'allocator'?"),
        (("reference", "x.fmu"), "there is no FMU x.fmu"),
        (("reference", "x.fmu", "--vector", "v"), "there is no FMU"),
        (("check", "x.fmu", "--as", "plant", "--tolerance", "nan"), "--tolerance nan: expected a number from 0"),
        (("check", "x.fmu", "--as", "plant", "--tolerance", "-1"), "--tolerance -1: expected a number from 0"),
    ],
)
def test_a_wrong_call_is_refused(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(main, list(arguments))
    assert (result.exit_code, message in result.stderr) == (2, True), result.stderr
