"""The notebooks run, and what they print is what is stored in them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

FOLDER = ROOT / "query" / "python" / "notebooks"
LARGEST_BYTES = 400_000
"""Drawings are stored, that a reader may see them; they stay small."""


@pytest.mark.parametrize("notebook", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_run_prints_what_is_stored(notebook, program, tmp_path):
    for name in ("tests", "query"):
        (tmp_path / name).symlink_to(ROOT / name)
    index = program("grasp-builder", "build", "--hands", 4, "--out", tmp_path / "grasp.idx")
    assert index.returncode == 0, index.stderr
    run = subprocess.run(
        [sys.executable, FOLDER / "run.py", notebook, "--folder", tmp_path],
        env={**os.environ, "MPLBACKEND": "", "IPYTHONDIR": str(tmp_path / "ipython")},
        capture_output=True,
        text=True,
        check=False,
        timeout=900,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert notebook.stat().st_size < LARGEST_BYTES
    assert str(Path.home()) not in notebook.read_text()
