"""What is asked for wrongly is said before anything is measured."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent


class Arguments(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.at = Path(folder.name)
        self.base = str(self.at / "base.npy")
        np.save(self.base, np.eye(20, dtype=np.float32))

    def refused(self, *words: str) -> str:
        """The error of a run that ends at once, with nothing built."""
        work = self.at / "work"
        command = [sys.executable, HERE / "bench.py", *words, "--work", work]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertFalse(work.exists() and any(work.iterdir()))
        return done.stderr

    def test_numbers_that_measure_nothing(self) -> None:
        for option in ("--k", "--rounds", "--repeats", "--build-threads"):
            self.assertIn("at least 1", self.refused(self.base, self.base, option, "0"))
        self.assertIn("above 0", self.refused(self.base, self.base, "--recall-levels", ".9,high"))
        free = max(os.sched_getaffinity(0)) + 1
        self.assertIn(f"--core {free}", self.refused(self.base, self.base, "--core", str(free)))

    def test_a_table_that_cannot_be_written(self) -> None:
        said = self.refused(self.base, self.base, "--csv", str(self.at / "none" / "points.csv"))
        self.assertIn("points.csv", said)

    def test_what_is_no_array(self) -> None:
        text = self.at / "text.npy"
        text.write_text("none")
        self.assertIn("text.npy", self.refused(self.base, str(text)))


if __name__ == "__main__":
    unittest.main()
