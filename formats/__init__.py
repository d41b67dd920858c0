"""Writes the results of a run in the formats of the field, and reads attitude from them.

CCSDS AEM and OEM, MCAP, SPICE CK and HDF5. It knows attitude, rate, position and epoch, which `orchestration` does not;
its command, `orchestrate convert`, is an entry point (pyproject.toml).
"""
