"""The vectors of a comparison, from an index of this project: what it holds, and what is searched for in it."""

from __future__ import annotations

import csv
import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from peers.ours import tool

SAMPLES = Path(__file__).resolve().parent.parent / "pictures" / "labels.csv"
"""The pictures that are searched for where no others are named: of one hand, six with a mask."""
MANIFEST = ("file", "grasp", "qx", "qy", "qz", "qw")
DARKEST = 9
"""Of a hand's pixels, so that none counts as black."""
MOVED_SEED, HELD_OUT_SEED = 7, 8
"""Queries are drawn by one seed; those that our own index measures its search by, by another."""


@dataclass(frozen=True)
class Vectors:
    """Paths of arrays, and what their rows are."""

    base: str
    queries: dict[str, str]
    """By what the queries are."""
    held_out: str
    """What our own index measures its search by; empty: by its own rows."""
    descriptor: str
    """For the table's head."""


def of_index(index: str, pictures: Path, work: Path, binaries: str, entries: int | None = None) -> Vectors:
    """Writes the arrays into `work`, of all entries or of so many. Raises ValueError saying what does not fit, and
    OSError.

    The queries are of two kinds: `moved`, of hands that no index holds, rendered as the index's own and moved as far
    from their neighbours as real pictures are; and `pictures`, of the hands in a table of labelled pictures, as
    `grasp-query evaluate` reads it, with the masks that it names.
    """
    builder = tool("grasp-builder", binaries)
    facts = inspected(builder, index)
    name, dim = facts["descriptor"]["name"], facts["descriptor"]["dim"]
    if not facts["recognises"]:
        raise ValueError(f"{index} is not of pictures: name an index that recognises, or two arrays")
    base, moved, held_out, seen = (
        work / f"{array}.npy" for array in ("base", "moved", "held_out", "pictures")
    )
    called(builder, "export", index, "--descriptors", base)
    if entries is not None:
        np.save(base, evenly(np.load(base), entries))
    describe = ["--descriptor", name, "--preset", preset(facts)]
    called(builder, "queries", *describe, "--seed", MOVED_SEED, "--out", moved)
    # A build moves them itself.
    called(builder, "queries", *describe, "--clean", "--seed", HELD_OUT_SEED, "--out", held_out)
    count = cut_out(pictures, work / "pictures")
    shown = work / "pictures.idx"
    plain = ["--originals", "f32", "--thumbnails", 0]
    called(builder, "build", work / "pictures", "--descriptor", name, *plain, "--out", shown)
    if inspected(builder, str(shown))["descriptor"] != facts["descriptor"]:
        raise ValueError(
            f"{index} describes pictures otherwise than these programs do, by another network: build it anew"
        )
    called(builder, "export", shown, "--descriptors", seen)
    return Vectors(
        base=str(base),
        queries={f"{count:,} pictures ({pictures})": str(seen), "renders of other hands, moved": str(moved)},
        held_out=str(held_out),
        descriptor=f"`{name}`, D = {dim}",
    )


def evenly(rows: np.ndarray, count: int) -> np.ndarray:
    """So many of the rows, from first to last; raises ValueError where there are fewer."""
    if count > len(rows):
        raise ValueError(f"the index has {len(rows):,} entries, {count:,} are asked for")
    return rows[np.arange(count) * len(rows) // count]


def preset(facts: dict) -> str:
    """How the index's own views are posed and seen."""
    for line in facts["provenance"]:
        if line["name"] == "options":
            return json.loads(line["value"]).get("preset", "standard")
    return "standard"


def cut_out(labels: Path, folder: Path) -> int:
    """Makes a render set of the pictures with a mask, or on black, and says how many there are. Left hands are
    turned into right ones, as recognition does."""
    from PIL import Image, ImageOps

    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    with open(labels, newline="") as stream:
        for at, row in enumerate(csv.DictReader(stream)):
            if not row.get("mask") and row.get("kind") != "segmented":
                continue
            picture = Image.open(labels.parent / row["file"]).convert("L")
            if row.get("mask"):
                mask = Image.open(labels.parent / row["mask"]).convert("L").resize(picture.size)
                hand = mask.point(lambda value: 255 * (value > 127))
                # A render set's hand is what is not black.
                lit = picture.point(lambda value: max(value, DARKEST))
                picture = Image.composite(lit, Image.new("L", picture.size), hand)
            if row.get("hand") == "left":
                picture = ImageOps.mirror(picture)
            name = f"{at:06}.png"
            picture.save(folder / name)
            rows.append([name, row["grasp"], 0, 0, 0, 1])
    if not rows:
        raise ValueError(f"{labels} names no picture with a mask, and none on black")
    with open(folder / "manifest.csv", "w", newline="") as stream:
        csv.writer(stream).writerows([MANIFEST, *rows])
    return len(rows)


def inspected(builder: str, index: str) -> dict:
    return json.loads(called(builder, "inspect", index, "--json"))


def called(*words: object) -> str:
    """Runs a program and returns its standard output; raises ValueError in its own words where it fails."""
    call = [str(word) for word in words]
    done = subprocess.run(call, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(f"{' '.join(call[:2])}: {done.stderr.strip()[-300:]}")
    return done.stdout
