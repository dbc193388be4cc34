"""The rounds: every contender once, then every contender again, so that a busy minute harms all of them alike."""

from __future__ import annotations

import random
import statistics
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from truth import Judge, Score

from .contender import Contender, Run, Setting
from .pool import Built, Failed, Process, Store

NEAR_BEST = 1.4
"""After the first round only settings within this factor of the best at some level are timed again."""


@dataclass
class Point:
    """One setting of one contender."""

    setting: Setting
    score: Score
    ns: list[float] = field(default_factory=list)
    """Nanoseconds a query, one a round."""
    predicted: float | None = None
    """The recall that the contender said it would find, where it says any."""

    @property
    def median_us(self) -> float:
        return statistics.median(self.ns) / 1000

    def reaches(self, level: Level) -> bool:
        return getattr(self.score, level[0]) >= level[1]


Level = tuple[str, float]
"""A field of `Score` and the value that it must reach."""


@dataclass
class Entry:
    """A contender's part in the run."""

    contender: Contender
    built: Built | None = None
    memory_bytes: int = 0
    load_seconds: float = 0.0
    points: list[Point] = field(default_factory=list)
    failed: str = ""
    refused: list[str] = field(default_factory=list)
    """Settings that it would not take, and why."""

    def best(self, level: Level) -> Point | None:
        """The fastest point that reaches a level."""
        return min((p for p in self.points if p.reaches(level)), key=lambda p: p.median_us, default=None)


@dataclass
class Plan:
    run: Run
    levels: list[Level]
    rounds: int
    repeats: int
    core: int
    limit: float
    """Seconds that loading or one search may take."""
    in_turn: bool
    """One index in memory at a time, loaded anew in every round."""
    scratch: Path


def hold(entries: list[Entry], plan: Plan, store: Store, judge: Judge, say: Callable[[str], None]) -> None:
    """Times all entries that were built, filling in their points."""
    order = random.Random(plan.run.seed)
    workers: dict[str, Process] = {}
    try:
        for number in range(plan.rounds):
            running = [entry for entry in entries if not entry.failed]
            order.shuffle(running)
            for entry in running:
                say(f"round {number + 1} of {plan.rounds}: {entry.contender.name}")
                try:
                    worker = workers.get(entry.contender.name) or load(entry, plan, store)
                    workers[entry.contender.name] = worker
                    one_turn(entry, worker, plan, judge, first=number == 0)
                except Failed as error:
                    entry.failed = str(error)
                if entry.failed or plan.in_turn:
                    if gone := workers.pop(entry.contender.name, None):
                        gone.stop()
    finally:
        for worker in workers.values():
            worker.stop()


def load(entry: Entry, plan: Plan, store: Store) -> Process:
    worker = Process(entry.contender, plan.run, 1, store.log(entry.contender))
    try:
        answer = worker.ask(plan.limit, do="load", folder=str(entry.built.folder), core=plan.core)
    except Failed:
        worker.stop()
        raise
    entry.load_seconds, entry.memory_bytes = answer["seconds"], answer["bytes"]
    return worker


def one_turn(entry: Entry, worker: Process, plan: Plan, judge: Judge, first: bool) -> None:
    """One contender's settings, once each, after a search that is not timed: others have had the caches since."""
    settings = entry.contender.settings(plan.run)
    if first:
        sweep(entry, worker, plan, judge, settings)
        return
    worth = contending(entry.points, plan.levels)
    if worth:
        worker.ask(plan.limit, do="search", setting=worth[0].setting, repeats=1, out="")
    for point in worth:
        answer = worker.ask(plan.limit, do="search", setting=point.setting, repeats=plan.repeats, out="")
        point.ns.append(answer["ns"])


def sweep(entry: Entry, worker: Process, plan: Plan, judge: Judge, settings: list[Setting]) -> None:
    """The first round: every setting that may win, with its answers judged."""
    out = plan.scratch / f"{entry.contender.name}.npy"
    warm = False
    for setting in settings:
        if hopeless(setting, entry.points, plan.levels):
            continue
        try:
            if not warm:
                worker.ask(plan.limit, do="search", setting=setting, repeats=1, out="")
                warm = True
            answer = worker.ask(plan.limit, do="search", setting=setting, repeats=plan.repeats, out=str(out))
        except Failed as error:
            if worker.child.poll() is not None:
                raise
            entry.refused.append(f"{setting}: {error}")
            continue
        entry.points.append(Point(setting, judge.score(np.load(out)), [answer["ns"]], answer["predicted"]))
    if not entry.points:
        raise Failed(entry.refused[0] if entry.refused else "no settings")


def hopeless(setting: Setting, points: list[Point], levels: list[Level]) -> bool:
    """Whether a setting costs more than one that reaches every level already: it asks no less in any parameter than
    another that did cost more."""
    able = [point.median_us for point in points if all(point.reaches(level) for level in levels)]
    dear = NEAR_BEST * min(able, default=float("inf"))
    return any(
        point.median_us > dear and all(setting.get(name, 0) >= value for name, value in point.setting.items())
        for point in points
    )


def contending(points: list[Point], levels: list[Level]) -> list[Point]:
    """The points that may yet be the fastest at some level."""
    worth: dict[int, Point] = {}
    for level in levels:
        reaching = [point for point in points if point.reaches(level)]
        least = min((point.median_us for point in reaching), default=0.0)
        worth.update({id(point): point for point in reaching if point.median_us <= NEAR_BEST * least})
    return [point for point in points if id(point) in worth]
