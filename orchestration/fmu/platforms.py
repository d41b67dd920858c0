"""What FMI calls this platform, and how its libraries end; as FMPy has it, whose import takes long."""

from __future__ import annotations

import platform
import sys

_BITS = 64 if sys.maxsize > 2**32 else 32
_ARM = platform.machine().lower() in ("aarch64", "arm64")
_SYSTEM = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")

_USUAL = f"{_SYSTEM[:3] if _SYSTEM == 'windows' else _SYSTEM}{_BITS}"
PLATFORMS_2 = ("aarch64-linux", _USUAL) if _ARM and _SYSTEM == "linux" else (_USUAL,)
"""In FMI 2.0, the first that an FMU has: linux64. For Linux on Arm, of which 2.0 knows nothing, this project takes the
name of 3.0, other tools linux64."""
PLATFORM = PLATFORMS_2[0]
PLATFORM_3 = f"{'aarch64' if _ARM else 'x86_64' if _BITS == 64 else 'x86'}-{_SYSTEM}"
"""In FMI 3.0: x86_64-linux."""
SUFFIX = {"windows": ".dll", "darwin": ".dylib", "linux": ".so"}[_SYSTEM]
"""Of a library."""
