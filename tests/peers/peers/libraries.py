"""The table of contenders, in the order of the report."""

from __future__ import annotations

from importlib import metadata

from .contender import Contender
from .faiss_peers import Flat, Hnsw, IvfFlat, IvfPqFastScan
from .graphs import Glass, HnswLib, Svs, SymphonyQg, USearch
from .ours import Grasp, GraspPython
from .trees import Annoy, ScaNN


def contenders() -> dict[str, Contender]:
    """Every contender by name. Two rows of one library differ in how the index is built."""
    table = [
        Grasp(),
        GraspPython(),
        Flat(),
        IvfFlat(4),
        IvfPqFastScan(4, residuals=True),
        IvfPqFastScan(4, residuals=False),
        Hnsw(),
        HnswLib(),
        USearch("f32"),
        USearch("f16"),
        Annoy(),
        ScaNN(),
        SymphonyQg(),
        Glass(),
        Svs(),
    ]
    return {contender.name: contender for contender in table}


def version(contender: Contender) -> str:
    """The installed version of the contender's distribution; empty where it is not a distribution."""
    if not contender.package:
        return ""
    try:
        return metadata.version(contender.package)
    except metadata.PackageNotFoundError:
        return "not installed"
