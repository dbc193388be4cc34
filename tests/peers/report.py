"""The run as a Markdown table and as a CSV file."""

from __future__ import annotations

import csv
import json
import platform
import time
from pathlib import Path
from typing import Any, TextIO

from peers.cold import Cold
from peers.contender import Run
from peers.libraries import version
from peers.rounds import Entry, Level, Plan

FEW = 100
"""Queries below which a call's own cost shows in what each of them takes."""


def number(value: float | None) -> str:
    """Three figures are more than such a measurement is worth."""
    if value is None:
        return "-"
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def level_name(level: Level, k: int) -> str:
    what = f"R@{k}" if level[0] == "recall" else "eps-success"
    return f"{what} >= {level[1]:.3f}".rstrip("0").replace("0.", ".", 1)


def table(entries: list[Entry], levels: list[Level], cold: dict[str, Cold], run: Run) -> str:
    """Microseconds a query at each level, the least of each column in bold, and what it costs to have the index."""
    ran = [entry for entry in entries if not entry.failed]
    least = []
    for level in levels:
        found = [best.median_us for entry in ran if (best := entry.best(level))]
        least.append(min(found, default=None))
    names = [level_name(level, run.k) for level in levels]
    heads = ["us a query, one core", *names, "build s", "memory MB", "disk MB", "cold start ms"]
    rows = [heads, ["---"] * len(heads)]
    for entry in entries:
        rows.append(line(entry, run, levels, least, cold))
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def line(
    entry: Entry, run: Run, levels: list[Level], least: list[float | None], cold: dict[str, Cold]
) -> list[str]:
    how = entry.contender.parameters(run)
    title = f"{entry.contender.title} ({how})" if how else entry.contender.title
    if entry.failed:
        return [title, f"did not run: {entry.failed}".replace("|", "/"), *[""] * (len(levels) + 3)]
    cells = []
    for level, record in zip(levels, least, strict=True):
        best = entry.best(level)
        cell = number(best.median_us if best else None)
        cells.append(f"**{cell}**" if best and best.median_us == record else cell)
    start = cold.get(entry.contender.name)
    cells.append(number(entry.built.seconds))
    cells.append("mapped" if entry.contender.ours else number(entry.memory_bytes / 1e6))
    cells.append(number(entry.built.disk_bytes / 1e6))
    cells.append(
        "-" if start is None else number(start.whole) + (f" ({number(start.inside)})" if start.inside else "")
    )
    return [title, *cells]


def notes(entries: list[Entry], plan: Plan, queries: int, eps: float) -> str:
    """What one must know to repeat the run."""
    run = plan.run
    versions = {e.contender.package: version(e.contender) for e in entries if e.contender.package}
    threads = sorted({entry.built.threads for entry in entries if entry.built})
    built = f", builds with {', '.join(map(str, threads))} thread(s)" if threads else ""
    lines = [
        f"- {time.strftime('%Y-%m-%d')}, {machine()}; searches on core {plan.core} with one thread"
        f"{built}.",
        f"- {run.n:,} vectors of {run.dim} dimensions, {queries:,} queries, k {run.k}, seed {run.seed}; medians of "
        f"{plan.rounds} interleaved rounds, in each the median of {plan.repeats} batches of all queries"
        + (", one index in memory at a time." if plan.in_turn else "."),
        "- recall counts ties of the k-th distance; eps-success: the share of queries whose nearest answer is "
        f"within {1 + eps:g} of the true nearest distance. `-`: never reached.",
        "- build: from the vectors in memory to the index on disk (grasp's programs: the whole process). Memory: "
        "growth of the process by loading. Cold start: whole process, files in the page cache; in brackets "
        "the part spent opening and answering, without the interpreter.",
        "- "
        + ", ".join(f"{name} {number}" for name, number in versions.items())
        + f", Python {platform.python_version()}.",
    ]
    if queries < FEW:
        lines.append(
            f"- few queries: a call from Python takes some microseconds, which {queries} queries share; grasp's "
            "programs are timed without one."
        )
    for entry in entries:
        said = [point for point in entry.points if point.predicted is not None]
        if said:
            pairs = ", ".join(f"{point.predicted:.3f} {point.score.recall:.3f}" for point in said)
            lines.append(
                f"- recall@{run.k} that {entry.contender.name} predicted, and that it found: {pairs}."
            )
        if entry.refused:
            lines.append(
                f"- {entry.contender.name} refused {len(entry.refused)} settings, the first: {entry.refused[0]}"
            )
    return "\n".join(lines)


def machine() -> str:
    """The processor, its cores and caches, as the kernel tells them."""
    facts: dict[str, str] = {}
    for text in Path("/proc/cpuinfo").read_text().splitlines():
        key, _, value = text.partition(":")
        facts.setdefault(key.strip(), value.strip())
    cores = sum(text.startswith("processor") for text in Path("/proc/cpuinfo").read_text().splitlines())
    wide = (
        "AVX-512"
        if "avx512bw" in facts.get("flags", "")
        else "AVX2" if "avx2" in facts.get("flags", "") else "no AVX2"
    )
    caches = []
    for index in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        kind = (index / "type").read_text().strip()
        if kind != "Instruction":
            caches.append(f"L{(index / 'level').read_text().strip()} {(index / 'size').read_text().strip()}")
    return f"{facts.get('model name', platform.processor())} ({wide}), {cores} cores, {', '.join(caches)}"


def write_csv(tables: list[tuple[str, list[Entry]]], stream: TextIO) -> None:
    """Every point, one a row, of all tables, each with what its queries are."""
    writer = csv.writer(stream)
    writer.writerow(
        [
            "queries",
            "contender",
            "version",
            "setting",
            "recall",
            "eps_success",
            "us_median",
            "us_least",
            "us_most",
            "rounds",
            "build_s",
            "memory_bytes",
            "disk_bytes",
            "error",
        ]
    )
    for title, entries in tables:
        for entry in entries:
            write_points(title, entry, writer)


def write_points(title: str, entry: Entry, writer: Any) -> None:
    head = [title, entry.contender.name, version(entry.contender)]
    tail = [entry.built.seconds, entry.memory_bytes, entry.built.disk_bytes] if entry.built else ["", "", ""]
    for point in entry.points:
        us = [value / 1000 for value in point.ns]
        middle = [json.dumps(point.setting), point.score.recall, point.score.eps_success]
        figures = [round(value, 3) for value in (point.median_us, min(us), max(us))]
        writer.writerow([*head, *middle, *figures, len(us), *tail, ""])
    if entry.failed:
        writer.writerow([*head, "", "", "", "", "", "", 0, *tail, entry.failed])
