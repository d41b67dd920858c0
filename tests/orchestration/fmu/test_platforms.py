"""The names of this platform, against FMPy's."""

from __future__ import annotations

import fmpy

from orchestration.fmu import platforms


def test_this_platform_is_called_as_fmpy_calls_it() -> None:
    assert (fmpy.platform, fmpy.platform_tuple) == (platforms.PLATFORM, platforms.PLATFORM_3)
    assert fmpy.sharedLibraryExtension == platforms.SUFFIX
