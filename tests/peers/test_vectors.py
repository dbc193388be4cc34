"""What becomes of a table of labelled pictures."""

import csv
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

import vectors


class Pictures(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.at = Path(self.folder.name)

    def tearDown(self) -> None:
        self.folder.cleanup()

    def table(self, *rows: dict[str, str]) -> Path:
        path = self.at / "labels.csv"
        with open(path, "w", newline="") as stream:
            table = csv.DictWriter(stream, ("file", "mask", "kind", "grasp", "hand"))
            table.writeheader()
            table.writerows(rows)
        return path

    def test_the_hand_is_what_its_mask_says_and_never_black(self) -> None:
        grey = np.full((20, 30), 200, dtype=np.uint8)
        grey[5:15, 4:6] = 0  # a shadow on the hand
        mask = np.zeros_like(grey)
        mask[5:15, 4:14] = 255
        Image.fromarray(grey).save(self.at / "a.png")
        Image.fromarray(mask).save(self.at / "m.png")
        row = {"file": "a.png", "mask": "m.png", "kind": "camera", "grasp": "pinch"}
        scene = {"file": "scene.jpg", "kind": "camera", "grasp": "pinch", "hand": "right"}
        labels = self.table({**row, "hand": "right"}, scene, {**row, "hand": "left"})
        self.assertEqual(vectors.cut_out(labels, self.at / "out"), 2)
        with open(self.at / "out" / "manifest.csv", newline="") as stream:
            files = [line["file"] for line in csv.DictReader(stream)]
        right, left = (np.asarray(Image.open(self.at / "out" / file)) for file in files)
        np.testing.assert_array_equal(right > 8, mask > 0)
        np.testing.assert_array_equal(left, right[:, ::-1])

    def test_a_table_without_masks_is_refused(self) -> None:
        labels = self.table({"file": "scene.jpg", "kind": "camera", "grasp": "pinch", "hand": "right"})
        with self.assertRaisesRegex(ValueError, "names no picture with a mask"):
            vectors.cut_out(labels, self.at / "out")

    def test_some_entries_are_taken_evenly(self) -> None:
        rows = np.arange(10, dtype=np.float32).reshape(5, 2)
        np.testing.assert_array_equal(vectors.evenly(rows, 5), rows)
        np.testing.assert_array_equal(vectors.evenly(rows, 2), rows[[0, 2]])
        with self.assertRaisesRegex(ValueError, "has 5 entries, 6 are asked for"):
            vectors.evenly(rows, 6)

    def test_the_preset_is_the_one_that_the_index_was_built_by(self) -> None:
        facts = {"provenance": [{"name": "options", "value": '{"version":1,"preset":"wide"}'}]}
        self.assertEqual(vectors.preset(facts), "wide")
        self.assertEqual(vectors.preset({"provenance": []}), "standard")


if __name__ == "__main__":
    unittest.main()
