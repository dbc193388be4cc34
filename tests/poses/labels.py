"""How far do the joints of a recorded pose tell its label?

    pip install -r requirements.txt && python labels.py

Trains common classifiers on joint angles, and prints the share of rightly named poses that were left
out: in all, in the mean over grasps, and of those whose label is clear. Left out are all poses with
one thing, or a random fifth, many of whose things are in the others.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from sklearn.ensemble import RandomForestClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import KFold, LeaveOneGroupOut, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC

POSES = Path(__file__).parents[2] / "renders" / "data" / "poses.csv"
LABELS = ["id", "source", "licence", "object", "grasp", "confidence"]
CLEAR = 3
CLASSIFIERS = {
    "nearest neighbour": KNeighborsClassifier(1),
    "three nearest neighbours": KNeighborsClassifier(3),
    "logistic regression": LogisticRegression(C=0.1, max_iter=5000),
    "support vectors": SVC(C=5),
    "random forest": RandomForestClassifier(400, random_state=0),
}


def main() -> None:
    with POSES.open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    columns = [name for name in rows[0] if name not in LABELS]
    angles = np.array([[float(row[name]) for name in columns] for row in rows])
    grasps = np.array([row["grasp"] for row in rows])
    things = np.array([row["object"] for row in rows])
    is_clear = np.array([int(row["confidence"]) == CLEAR for row in rows])

    names, counts = np.unique(grasps, return_counts=True)
    print(f"{len(rows)} poses of {len(set(things))} things, {is_clear.sum()} of them labelled clearly")
    print("by grasp: " + ", ".join(f"{name} {count}" for name, count in zip(names, counts)))
    folds = {
        "all poses with a thing": list(LeaveOneGroupOut().split(angles, grasps, things)),
        "a fifth of the poses": list(KFold(5, shuffle=True, random_state=0).split(angles)),
    }
    for left_out, splits in folds.items():
        print(f"\n| left out: {left_out} | all | mean over grasps | clear |\n|{'---|' * 4}")
        for name, classifier in CLASSIFIERS.items():
            model = make_pipeline(StandardScaler(), classifier)
            named = cross_val_predict(model, angles, grasps, cv=splits)
            is_right = named == grasps
            mean = np.mean([is_right[grasps == grasp].mean() for grasp in names])
            shares = [is_right.mean(), mean, is_right[is_clear].mean()]
            print(f"| {name} | " + " | ".join(f"{100 * share:.0f} %" for share in shares) + " |")


if __name__ == "__main__":
    main()
