"""Run a notebook and store its outputs, or check that they are those that are stored.

    notebooks/run.py notebooks/picture-to-pose.ipynb [--store] [--folder FOLDER]

runs it in FOLDER (by default the working directory) by the Python that runs this. What it prints
has to be what is stored, to the character; drawings only have to be there, because Matplotlib's
pixels differ from version to version. Exit status: 0, 1 where outputs differ or a cell fails.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat import NotebookNode

TIME_LIMIT_S = 900
"""What a cell may take; one of them builds an index."""


def ran(notebook: NotebookNode, folder: Path) -> NotebookNode:
    """Return a copy with the outputs of a run, and without what differs from run to run."""
    fresh = nbformat.from_dict(notebook)
    client = NotebookClient(fresh, timeout=TIME_LIMIT_S, resources={"metadata": {"path": str(folder)}})
    client.execute()
    fresh.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for cell in fresh.cells:
        cell.metadata = {}
        # Progress, of which a terminal would show the last line alone.
        if cell.cell_type == "code":
            cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]
            for output in cell.outputs:
                # The text that stands for a drawing names its size.
                if "image/png" in output.get("data", {}):
                    output.data["text/plain"] = "a drawing"
    return fresh


def shown(notebook: NotebookNode) -> list[str]:
    """Return what a reader sees of the outputs, line by line; of a drawing, that it is there."""
    lines = []
    for number, cell in enumerate(notebook.cells):
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            text = output.get("text") or data.get("text/plain", "")
            lines += [f"cell {number}: {line}" for line in text.splitlines()]
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("notebook", type=Path)
    parser.add_argument("--folder", type=Path, default=Path())
    parser.add_argument("--store", action="store_true", help="write the outputs into the notebook")
    given = parser.parse_args()
    stored = nbformat.read(given.notebook, as_version=4)
    try:
        fresh = ran(stored, given.folder)
    except CellExecutionError as error:
        print(f"{given.notebook}: {error}", file=sys.stderr)
        return 1
    if given.store:
        nbformat.write(fresh, given.notebook)
        return 0
    differences = list(difflib.unified_diff(shown(stored), shown(fresh), "stored", "run", lineterm="", n=0))
    if differences:
        print(*differences, sep="\n", file=sys.stderr)
        print(f"{given.notebook} shows other outputs than a run: look at them, and --store them", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
