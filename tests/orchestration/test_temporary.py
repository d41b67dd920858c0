"""Folders for temporary files of runs that were killed are removed by the next run, and nobody else's."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="on Windows no lock is taken")
MAKE = "import sys; from orchestration import temporary; print(temporary.make(), flush=True); sys.stdin.read()"
CLEAR = "from orchestration import temporary\nwith temporary.temporary(): pass"


def begun(code: str, place: Path) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(place)}
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", code], env=environment, stdin=pipe, stdout=pipe, text=True)


def folders(place: Path) -> set[str]:
    return {path.name for path in place.iterdir()}


def test_the_next_run_removes_what_a_killed_one_left_and_nothing_else(tmp_path):
    place = tmp_path / "temporary"
    place.mkdir()
    killed, lives = begun(MAKE, place), begun(MAKE, place)
    left, kept = (Path(process.stdout.readline().strip()) for process in (killed, lives))
    (left / "vendor").mkdir()
    (left / "vendor" / "binary").write_bytes(b"x")
    (place / "orchestrate-without-lock").mkdir()
    (place / "other").mkdir()
    (place / "other" / ".lock").write_text("")
    (place / "orchestrate-link").symlink_to(place / "other")
    (place / "orchestrate-file").write_text("")
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert left.exists()
    assert begun(CLEAR, place).wait(30) == 0
    others = {"orchestrate-without-lock", "orchestrate-link", "orchestrate-file", "other"}
    assert folders(place) == {kept.name, *others}
    assert (place / "other" / ".lock").exists()
    lives.communicate()
    assert begun(CLEAR, place).wait(30) == 0
    assert folders(place) == others


def test_a_folder_stays_while_a_process_that_was_forked_from_its_own_works_in_it(tmp_path):
    forked = "import os\nfrom orchestration import temporary\nfolder = temporary.make()\n" + (
        "if os.fork():\n    os.kill(os.getpid(), 9)\nprint(folder, flush=True)\nimport sys; sys.stdin.read()\n"
    )
    process = begun(forked, tmp_path)
    folder = Path(process.stdout.readline().strip())
    assert process.wait(30) == -signal.SIGKILL
    assert begun(CLEAR, tmp_path).wait(30) == 0
    assert folder.exists()
    process.stdin.close()
    process.stdout.read()
    assert begun(CLEAR, tmp_path).wait(30) == 0
    assert not folder.exists()


def test_a_folder_whose_deletion_was_killed_loses_its_lock_last(tmp_path):
    killed = "import os\nfrom orchestration import temporary\nfolder, real = temporary.make(), os.unlink\n" + (
        "for i in range(40):\n    (folder / f'{i}.so').touch()\n"
        "def unlink(path, **more):\n    real(path, **more)\n"
        "    if str(path).endswith('.lock'): os.kill(os.getpid(), 9)\n"
        "os.unlink = unlink\ntemporary.remove(folder)\n"
    )
    assert begun(killed, tmp_path).wait(30) == -signal.SIGKILL
    assert not list(tmp_path.rglob("*.so"))
