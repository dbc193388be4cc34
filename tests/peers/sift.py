"""Vectors that are none of ours: SIFT descriptors of the photographs that scikit-image and scikit-learn come with.

    python sift.py base.npy queries.npy && python bench.py base.npy queries.npy --work sift-work

Queries are of other photographs than the base: the right picture of a stereo pair whose left is in it, and a flower.
"""

from __future__ import annotations

import sys
from importlib import resources
from pathlib import Path

import numpy as np

BASE = {
    "skimage.data": (
        "astronaut.png brick.png camera.png chelsea.png coffee.png coins.png grass.png gravel.png "
        "hubble_deep_field.jpg ihc.png moon.png motorcycle_left.png retina.jpg rocket.jpg"
    ).split(),
    "sklearn.datasets.images": ["china.jpg"],
}
QUERIES = {"skimage.data": ["motorcycle_right.png"], "sklearn.datasets.images": ["flower.jpg"]}
SCALE = 2
"""Photographs are enlarged, so that there are enough."""
CONTRAST = 0.01
"""How faint a key point may be, of the 0.04 that is usual."""
QUERIES_TAKEN = 2_000


def descriptors(photographs: dict[str, list[str]]) -> np.ndarray:
    """One row of 128 values for each key point."""
    import cv2  # here, so that the usage can be read without it

    sift = cv2.SIFT_create(contrastThreshold=CONTRAST)
    rows = []
    for package, names in photographs.items():
        for name in names:
            encoded = np.frombuffer((resources.files(package) / name).read_bytes(), dtype=np.uint8)
            grey = cv2.imdecode(encoded, cv2.IMREAD_GRAYSCALE)
            grey = cv2.resize(grey, None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_CUBIC)
            rows.append(sift.detectAndCompute(grey, None)[1])
    return np.concatenate(rows)


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    base, queries = (Path(path) for path in sys.argv[1:])
    np.save(base, descriptors(BASE))
    rows = descriptors(QUERIES)
    np.save(queries, rows[:: max(1, len(rows) // QUERIES_TAKEN)][:QUERIES_TAKEN])


if __name__ == "__main__":
    main()
