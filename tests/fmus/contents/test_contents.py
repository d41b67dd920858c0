"""Beside its code, an FMU of either flavour holds documentation, licence, terminals and an icon; no checker has a
finding."""

from __future__ import annotations

import logging
import struct
import zipfile
import zlib
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.build import FLAVOURS, blocks_of, ensure
from fmus.contents.archive import common
from fmus.contents.icon import png
from fmus.interface import BLOCKS, INTERFACES, Interface, InterfaceError, load, parse


@pytest.fixture(scope="module")
def fmus() -> dict[str, dict[str, Path]]:
    return {flavour: {block: ensure(block, flavour) for block in blocks_of(flavour)} for flavour in FLAVOURS}


@pytest.fixture(
    params=[(flavour, block) for flavour in FLAVOURS for block in blocks_of(flavour)], ids=lambda p: " ".join(p)
)
def fmu(request: pytest.FixtureRequest, fmus: dict[str, dict[str, Path]]) -> Path:
    flavour, block = request.param
    return fmus[flavour][block]


def test_fmpy_has_no_finding_and_the_file_is_small(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []
    assert fmu.stat().st_size < 2**20


def test_fmu_manipulation_toolbox_has_no_finding(fmu: Path, caplog: pytest.LogCaptureFixture) -> None:
    from fmu_manipulation_toolbox.checker import get_checkers
    from fmu_manipulation_toolbox.operations import FMU

    with caplog.at_level(logging.DEBUG, "fmu_manipulation_toolbox"):
        for checker in get_checkers():
            FMU(str(fmu)).apply_operation(checker())
    assert [r.message for r in caplog.records if r.levelno >= logging.WARNING] == []
    assert "This FMU seems to be compliant with FMI-2.0." in caplog.text
    assert "No semantic error against the FMI-2 standard." in caplog.text


def test_the_terminals_are_valid_and_name_ports_that_are_there(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        names = set(archive.namelist())
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(etree.parse(schema)).assertValid(root)
    description = fmpy.read_model_description(str(fmu))
    variables = {v.name: v for v in description.modelVariables}
    members = [member.get("variableName") for member in root.iter("TerminalMemberVariable")]
    assert len(members) == len(set(members))
    feeds = {"output"} if description.modelName != "plant_judge" else set()
    assert {variables[name].causality for name in members} == {"input"} | feeds
    icons = {graphic.get("iconBaseName") for graphic in root.iter("TerminalGraphicalRepresentation")} | {"icon"}
    assert {f"terminalsAndIcons/{icon}{suffix}" for icon in icons for suffix in (".png", ".svg")} <= names


def test_every_input_of_the_loop_is_in_a_terminal_that_an_output_of_another_block_fits() -> None:
    """Terminals of one name have the same members with the same shapes and units, some of them as outputs."""
    found: dict[str, list[tuple[str, list[tuple[str, tuple[int, ...], str | None]]]]] = {}
    for block in BLOCKS:
        interface = load(block)
        for name, members in interface.terminals.items():
            variables = [interface.variables[member] for member in members]
            found.setdefault(name, []).append((variables[0].causality, [(v.name, v.shape, v.unit) for v in variables]))
        grouped = {member for members in interface.terminals.values() for member in members}
        assert {v.name for v in interface.of("input")} <= grouped
    for name, ends in found.items():
        if name.startswith("measured_"):  # in the place of the true ones: it fits where their names are mapped
            true = found[name.removeprefix("measured_")][0][1]
            assert [causality for causality, _ in ends].count("output") >= 1
            for _, measured in ends:
                assert measured == [(f"{member}_measured", *rest) for member, *rest in true]
            continue
        # What is all optional may be fed by ports of other names: u_applied by rods and wheel.
        alone = [load(block) for block in BLOCKS if name in load(block).terminals]
        members_of = [i.variables[member] for i in alone for member in i.terminals[name]]
        optional = all(
            v.optional or v.type == "boolean" for v in members_of
        )  # a boolean has its start where it is open
        assert {causality for causality, _ in ends} == {"input", "output"} or optional
        assert all(members == ends[0][1] for _, members in ends)


def test_a_terminal_of_inputs_and_outputs_is_refused() -> None:
    text = (INTERFACES / "allocator.toml").read_text("utf-8")
    with pytest.raises(InterfaceError, match="terminals.field: b_B, b_wheel: expected inputs only or outputs only"):
        parse(text.replace('field = ["b_B"]', 'field = ["b_B", "b_wheel"]'))


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def test_the_page_shows_every_port_its_equations_limits_and_host(fmu: Path) -> None:
    interface = load(fmu.stem)
    with zipfile.ZipFile(fmu) as archive:
        page, names = archive.read("documentation/index.html").decode(), set(archive.namelist())
    reader = _Page()
    reader.feed(page)
    assert reader.open == []
    text = "".join(reader.text)
    assert interface.equations
    assert interface.limits
    for part in (*_sentences(interface), *interface.variables, *interface.terminals):
        assert part in text
    assert {f"documentation/{name}" for name in ("icon.svg", "licenses/license.txt")} <= names
    assert "What a host needs" in text


def _sentences(interface: Interface) -> Iterator[str]:
    yield from (part for equation in interface.equations for part in equation)
    yield from interface.limits
    yield from (variable.description for variable in interface.variables.values())


def test_the_python_flavour_says_what_it_needs_where_a_user_looks(fmus: dict[str, dict[str, Path]]) -> None:
    for block in blocks_of("python"):
        python, native = (fmpy.read_model_description(str(fmus[f][block])) for f in ("python", "native"))
        assert native.description == load(block).description
        assert python.description.startswith(native.description)
        assert (
            "must hold Python 3.11 or later with numpy; any other host takes the native flavour" in python.description
        )
        assert "for hosts that hold Python 3.11 or later with numpy" in python.generationTool
        with zipfile.ZipFile(fmus["python"][block]) as archive:
            assert archive.read("resources/requirements.txt") == b"numpy>=1.26\n"
            assert "give it the native flavour" in archive.read("documentation/index.html").decode()


@pytest.mark.parametrize("name", sorted(p.name.removesuffix(".svg") for p in INTERFACES.glob("*.svg")))
def test_an_icon_s_png_shows_what_its_svg_draws(name: str) -> None:
    data = png((INTERFACES / f"{name}.svg").read_bytes(), 20)
    import io

    from matplotlib import image

    pixels = image.imread(io.BytesIO(data))
    assert pixels.shape == (20, 20, 4)
    assert len({tuple(p) for row in pixels.tolist() for p in row}) > 2
    assert zlib.crc32(data[12:29]) == struct.unpack(">I", data[29:33])[0]


def test_a_block_without_an_icon_of_its_own_has_that_of_the_block_in_whose_place_it_stands(tmp_path: Path) -> None:
    text = load("allocator").source
    icons = [
        common(parse(text.replace('name = "allocator"', f'name = "{name}"')), tmp_path, None, "")[
            "documentation/icon.svg"
        ]
        for name in ("allocator", "allocator_other", "other")
    ]
    assert icons[0] == icons[1] != icons[2]


def test_an_icon_draws_what_lies_on_top_and_smooths_edges() -> None:
    svg = (
        b'<svg xmlns="http://www.w3.org/2000/svg"><rect x="0" y="0" width="50" height="100" fill="#ff0000"/>'
        b'<polygon points="0,0 50,0 0,50" fill="#0000ff"/><circle cx="25" cy="75" r="10" fill="#00ff00"/></svg>'
    )
    rows = zlib.decompress(png(svg, 4)[41:-16])
    pixel = {(x, y): tuple(rows[17 * y + 1 + 4 * x : 17 * y + 5 + 4 * x]) for x in range(4) for y in range(4)}
    assert pixel[0, 0] == (0, 0, 255, 255)
    assert pixel[0, 2][:2] != (255, 0)  # the circle takes its corner
    assert pixel[3, 1] == (0, 0, 0, 0)
    red, green, blue, opaque = pixel[1, 0]
    assert red > 0
    assert blue > 0
    assert (green, opaque) == (0, 255)
