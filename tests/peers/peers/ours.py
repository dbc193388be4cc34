"""This project's own index: through its two programs, and from Python, as users call them."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from .contender import Contender, Run, Setting

FILE = "grasp.idx"
ORIGINALS = "f16"
"""What exact distances are measured by, as the default presets keep it; the table says so."""
RECALLS = (0.80, 0.85, 0.90, 0.92, 0.94, 0.95, 0.96, 0.97, 0.98, 0.985, 0.99, 0.995, 0.998)


class Grasp(Contender):
    """The programs tell their own time a query; starting them is measured apart, as the cold start."""

    name, title, package = "grasp", "grasp", ""
    ours = True

    def parameters(self, run: Run) -> str:
        return f"this project, originals {ORIGINALS}"

    def prepare(self) -> None:
        self.folder: Path | None = None

    def build(self, run: Run, folder: Path) -> None:
        call = [
            program(run, "grasp-builder"),
            "build",
            "--descriptors",
            run.base,
            "--out",
            str(folder / FILE),
        ]
        call += ["--seed", str(run.seed), "--threads", str(run.build_threads)]
        if run.held_out:
            call += ["--held-out", run.held_out]
        call += ["--originals", ORIGINALS]
        subprocess.run(call, check=True, stdin=subprocess.DEVNULL)

    def load(self, run: Run, folder: Path) -> None:
        self.folder = folder
        program(run, "grasp-query")

    def settings(self, run: Run) -> list[Setting]:
        successes = (0.90, 0.95, 0.97, 0.99, 0.995)
        return [{"recall": r} for r in RECALLS] + [{"eps": 0.05, "success": s} for s in successes]

    def time_search(
        self, run: Run, queries: np.ndarray, setting: Setting, repeats: int
    ) -> tuple[float, np.ndarray]:
        with tempfile.TemporaryDirectory() as scratch:
            out = Path(scratch) / "ids.npy"
            call = [program(run, "grasp-query"), "search", run.queries, "--index", str(self.folder / FILE)]
            call += ["--k", str(run.k), "--out", str(out)]
            call += [word for name, value in setting.items() for word in (f"--{name}", str(value))]
            call += ["--rounds", str(repeats), "--threads", "1", "--json", "--timings"]
            done = subprocess.run(call, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True)
            if done.returncode != 0:
                raise RuntimeError(f"grasp-query: status {done.returncode}: {done.stderr.strip()[-300:]}")
            answer = json.loads(done.stdout.splitlines()[-1])
            # Asked for a success, it is not recall that it promises.
            self.predicted = answer.get("predicted_recall") if "recall" in setting else None
            return float(answer["ns_per_query"]), np.load(out).astype(np.int64)


class GraspPython(Contender):
    """The Python package, in one process like its peers and timed like them. It is asked for recalls alone."""

    name, title, package = "grasp-python", "grasp from Python", "grasp"
    ours = True

    def parameters(self, run: Run) -> str:
        return f"this project, originals {ORIGINALS}"

    def prepare(self) -> None:
        import grasp

        self.grasp = grasp

    def build(self, run: Run, folder: Path) -> None:
        path = folder / FILE
        held_out = np.load(run.held_out) if run.held_out else None
        built = self.grasp.build(
            run.base_vectors(),
            path,
            seed=run.seed,
            threads=run.build_threads,
            held_out=held_out,
            originals=ORIGINALS,
        )
        built.close()

    def load(self, run: Run, folder: Path) -> None:
        self.index = self.grasp.Index(folder / FILE)

    def settings(self, run: Run) -> list[Setting]:
        return [{"recall": recall} for recall in RECALLS]

    def search(self, queries: np.ndarray, k: int, setting: Setting) -> np.ndarray:
        return self.index.search(queries, k, setting["recall"], threads=1)[0]


def program(run: Run, name: str) -> str:
    """The path of one of the two programs."""
    return tool(name, run.binaries)


def tool(name: str, binaries: str) -> str:
    """The path of one of the two programs, in the folder `binaries` or, where that is empty, on the PATH."""
    found = shutil.which(name, path=binaries or None)
    if found is None:
        raise FileNotFoundError(
            f"{name} not found: build with `cargo build --release`, pass --binaries FOLDER"
        )
    return found
