"""The matrix as ReqIF 1.2 (OMG), which tools of requirements read.

Needs the package reqif.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from reqif.models.reqif_core_content import ReqIFCoreContent
from reqif.models.reqif_data_type import ReqIFDataTypeDefinitionString
from reqif.models.reqif_namespace_info import ReqIFNamespaceInfo
from reqif.models.reqif_req_if_content import ReqIFReqIFContent
from reqif.models.reqif_reqif_header import ReqIFReqIFHeader
from reqif.models.reqif_spec_hierarchy import ReqIFSpecHierarchy
from reqif.models.reqif_spec_object import ReqIFSpecObject, SpecObjectAttribute
from reqif.models.reqif_spec_object_type import ReqIFSpecObjectType, SpecAttributeDefinition
from reqif.models.reqif_specification import ReqIFSpecification
from reqif.models.reqif_specification_type import ReqIFSpecificationType
from reqif.models.reqif_types import SpecObjectAttributeType
from reqif.object_lookup import ReqIFObjectLookup
from reqif.reqif_bundle import ReqIFBundle
from reqif.unparser import ReqIFUnparser

NAMES = {"id": "ReqIF.ForeignID", "text": "ReqIF.Text", "source": "Source"}
"""Of the implementation guide, where it has one; a kind of evidence is called as in the table."""
_TEXT = SpecObjectAttributeType.STRING
_CHANGED = "2026-01-01T00:00:00Z"
"""A file that says when it was written would differ each time."""


def write(head: Sequence[str], rows: Sequence[Sequence[str]], path: Path) -> None:
    """Each row as a requirement with the cells of the head; the first is its id."""
    data = ReqIFDataTypeDefinitionString("text", last_change=_CHANGED, long_name="text", max_length="100000")
    attributes = [
        SpecAttributeDefinition(_TEXT, f"of-{name}", "text", last_change=_CHANGED, long_name=NAMES.get(name, name))
        for name in head
    ]
    kind = ReqIFSpecObjectType("requirement", None, _CHANGED, "Requirement", attributes)
    whole = ReqIFSpecificationType("requirements", None, _CHANGED, "Requirements", is_self_closed=True)
    objects = [
        ReqIFSpecObject(
            row[0],
            [SpecObjectAttribute(_TEXT, f"of-{name}", cell) for name, cell in zip(head, row, strict=True)],
            kind.identifier,
            last_change=_CHANGED,
        )
        for row in rows
    ]
    places = [
        ReqIFSpecHierarchy(identifier=f"place-{row[0]}", spec_object=row[0], level=1, last_change=_CHANGED)
        for row in rows
    ]
    specification = ReqIFSpecification(
        "all", None, _CHANGED, "Requirements", specification_type=whole.identifier, children=places
    )
    header = ReqIFReqIFHeader(
        *("header", None, _CHANGED, None, "reqif", "1.0", "attitude-cosim"), title="Requirements and their evidence"
    )
    content = ReqIFReqIFContent([data], [kind, whole], objects, [], [specification], [])
    bundle = ReqIFBundle(
        ReqIFNamespaceInfo.create_default(),
        header,
        ReqIFCoreContent(content),
        tool_extensions_tag_exists=False,
        lookup=ReqIFObjectLookup.empty(),
        exceptions=[],
    )
    path.write_text(ReqIFUnparser.unparse(bundle), "utf-8")
