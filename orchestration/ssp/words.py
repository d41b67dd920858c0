"""The names that SSP 1.0 and our archives use."""

from __future__ import annotations

from xml.etree import ElementTree as ET

NAMESPACES = {
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
}
OPENMODELICA = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
"""The namespace of OMSimulator's annotation."""
OPENMODELICA_ANNOTATION = "org.openmodelica"
ANNOTATION = "orchestrate.scenario"
"""Type of the annotation that holds the rest of the scenario, as JSON."""
STRUCTURE = "SystemStructure.ssd"
PARAMETER_SET = "start"
"""Name of every parameter set: ecos applies all those of one name together."""

for _prefix, _uri in (NAMESPACES | {"oms": OPENMODELICA}).items():
    ET.register_namespace(_prefix, _uri)
