"""Worker processes seen from the program: started, asked, stopped; and the indexes that they build, on disk."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from .contender import Contender, Run
from .libraries import version

HERE = Path(__file__).resolve().parent.parent
THREAD_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMEXPR_NUM_THREADS")


class Failed(Exception):
    """A contender that did not do what it was asked; the message is what the table shows."""


class Process:
    """One worker. Every request has a time limit, past which the process is ended."""

    def __init__(self, contender: Contender, run: Run, threads: int, log: Path) -> None:
        environment = {**os.environ, **{name: str(threads) for name in THREAD_VARIABLES}}
        self.log = log
        with open(log, "a") as sink:
            self.child = subprocess.Popen(
                [sys.executable, "-m", "peers.worker", contender.name, json.dumps(dataclasses.asdict(run))],
                cwd=HERE,
                env=environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=sink,
                text=True,
                start_new_session=True,
            )

    def ask(self, limit: float, **request: Any) -> dict[str, Any]:
        """The answer to a request; raises `Failed` where there is none within `limit` seconds."""
        late = threading.Event()

        def stop() -> None:
            late.set()
            self.stop()

        timer = threading.Timer(limit, stop)
        timer.start()
        try:
            self.child.stdin.write(json.dumps(request) + "\n")
            self.child.stdin.flush()
            line = self.child.stdout.readline()
        except BrokenPipeError:
            line = ""
        finally:
            timer.cancel()
        if late.is_set():
            raise Failed(f"{request['do']} stopped after {limit:g} s")
        if not line:
            code = self.child.wait()
            how = signal.Signals(-code).name if code < 0 else f"status {code}"
            raise Failed(f"{request['do']} crashed ({how}), see {self.log.name}")
        answer = json.loads(line)
        if "error" in answer:
            raise Failed(answer["error"].splitlines()[0][:200])
        return answer

    def stop(self) -> None:
        """Ends the process and whatever it started."""
        try:
            os.killpg(self.child.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.child.wait()


@dataclasses.dataclass
class Built:
    """An index on disk."""

    folder: Path
    seconds: float
    threads: int
    disk_bytes: int


class Store:
    """The indexes of one set of vectors, each in a folder named after all that its bytes depend on."""

    def __init__(self, work: Path, run: Run, base_hash: str) -> None:
        self.root = work / base_hash
        self.root.mkdir(parents=True, exist_ok=True)
        self.run = run

    def log(self, contender: Contender) -> Path:
        return self.root / f"{contender.name}.log"

    def built(self, contender: Contender, limit: float, again: bool = False) -> Built:
        """The index of a contender, built where it is not there; a half-built one is never taken for whole."""
        what = repr((contender.parameters(self.run), version(contender), self.run.seed, self.run.k))
        digest = hashlib.blake2b(what.encode(), digest_size=6).hexdigest()
        folder = self.root / f"{contender.name}-{digest}"
        note = folder / "built.json"
        if again or contender.ours:
            shutil.rmtree(folder, ignore_errors=True)
        if not note.exists():
            self.build(contender, folder, note, limit)
        facts = json.loads(note.read_text())
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and path != note)
        if contender.needs_vectors:
            size += Path(self.run.base).stat().st_size
        return Built(folder, facts["seconds"], facts["threads"], size)

    def build(self, contender: Contender, folder: Path, note: Path, limit: float) -> None:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        process = Process(contender, self.run, self.run.build_threads, self.log(contender))
        try:
            answer = process.ask(limit, do="build", folder=str(folder))
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        finally:
            process.stop()
        note.write_text(json.dumps({"seconds": answer["seconds"], "threads": self.run.build_threads}))
