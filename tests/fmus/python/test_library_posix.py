"""A process that has loaded an FMU of the Python flavour ends without a write to memory that it has freed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

# Keeps what C++ frees, in another shape, and looks whether it is as it was left.
WITNESS = """
#include <stddef.h>
#include <stdio.h>
#include <string.h>
enum { MOST = 65536, LEFT = 0xA5 };
static unsigned char *kept[MOST];
static size_t sizes[MOST], count;
void _ZdlPvm(void *p, size_t size)
{
    if (p != NULL && count < MOST) {
        memset(p, LEFT, size);
        kept[count] = p;
        sizes[count++] = size;
    }
}
void look(void)
{
    size_t written = 0;
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < sizes[i]; k++) {
            written += kept[i][k] != LEFT;
        }
    }
    fprintf(stderr, "freed %s, %zu written\\n", count > 0 ? "some" : "none", written);
}
"""
LAST = """
void look(void);
__attribute__((destructor)) static void at_the_end(void) { look(); }
"""
# A library that is loaded last ends last.
HOST = """
import ctypes
import sys
import fmpy, fmpy.fmi2
description = fmpy.read_model_description(sys.argv[1])
fmu = fmpy.fmi2.FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(sys.argv[1], sys.argv[2]),
                          modelIdentifier=description.coSimulation.modelIdentifier, instanceName="toy")
fmu.instantiate(); fmu.setupExperiment(); fmu.enterInitializationMode(); fmu.exitInitializationMode()
fmu.terminate()
fmu.freeInstance()
ctypes.CDLL(sys.argv[3])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="glibc's order at the end of a process")
def test_nothing_is_written_into_freed_memory_when_the_process_ends(
    path: Path, tmp_path: Path, c_compiler: None
) -> None:
    libraries = {name: tmp_path / f"{name}.so" for name in ("witness", "last")}
    for (name, library), text in zip(libraries.items(), (WITNESS, LAST), strict=True):
        source = tmp_path / f"{name}.c"
        source.write_text(text)
        subprocess.run(["cc", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
    run = subprocess.run(
        [sys.executable, "-c", HOST, str(path), str(tmp_path / "unpacked"), str(libraries["last"])],
        env={**os.environ, "LD_PRELOAD": str(libraries["witness"])},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr.splitlines()[-1] == "freed some, 0 written"
