"""A million rows of a log, read, packed and played: `python -m tests.bench_telemetry`, or as rows of `make bench`."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROWS = 1_000_000
SCENARIO = f"""name: log
step: 0.1 s
duration: {ROWS // 10} s
blocks:
  log:
    telemetry:
      file: log.csv
      time: {{column: t, scale: elapsed}}
      columns:
        omega_B_measured: {{of: [x, y, z], unit: deg/s}}
        b_B_measured: {{of: [bx, by, bz], unit: uT}}
record: {{interval: 1000 s}}
"""


def rows(row: Callable[[str, str, str], None]) -> None:
    """Computing time and largest memory of the first run, which packs the log, and of the next one."""
    with tempfile.TemporaryDirectory() as folder:
        with Path(folder, "log.csv").open("w", encoding="utf-8") as file:
            file.write("t,x,y,z,bx,by,bz\n")
            file.writelines(
                f"{0.1 * k:.1f},{k % 7}.25,{k % 11},{k % 13},{k % 17},{k % 19},{k % 23}\n" for k in range(ROWS)
            )
        Path(folder, "log.yaml").write_text(SCENARIO, "utf-8")
        for what in ("the first run", "the next one"):
            command = [sys.executable, "-m", "orchestration", "log.yaml", "--quiet"]
            process = subprocess.Popen(command, cwd=folder)
            _, status, used = os.wait4(process.pid, 0)
            text = f"{used.ru_utime + used.ru_stime:.1f} s" if status == 0 else "failed"
            row(f"a log of {ROWS:,} rows: {what}", text, f"{used.ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    rows(lambda *cells: print(*cells, sep="  ", flush=True))
