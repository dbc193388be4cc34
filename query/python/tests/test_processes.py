"""Threads, forked and spawned processes."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest
from conftest import CAMERA

import grasp

needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")


def test_threads_share_an_index(index, queries):
    expected, _ = index.search(queries)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: index.search(queries)[0], range(32)))
    assert all((ids == expected).all() for ids in found)


def test_other_threads_run_while_one_searches(index, vectors):
    many = numpy.tile(vectors, (4, 1))
    turns, done = 0, threading.Event()

    def search():
        index.search(many, exact=True, threads=1)
        done.set()

    worker = threading.Thread(target=search)
    worker.start()
    while not done.is_set():
        turns += 1
        time.sleep(0.0005)
    worker.join()
    # Who holds the interpreter's lock lets nobody count.
    assert turns > 5


def test_an_index_is_pickled_as_its_path(index, queries, monkeypatch, tmp_path):
    for mmap in (True, False):
        pickled = pickle.dumps(grasp.Index(os.path.relpath(index.path), mmap=mmap))
        assert len(pickled) < 500
        with monkeypatch.context() as elsewhere:
            elsewhere.chdir(tmp_path)
            again = pickle.loads(pickled)
            assert (again.search(queries)[0] == index.search(queries)[0]).all()


def search_in_child(task):
    index, queries = task
    return index.search(queries, threads=2)[0]


def recognise_in_child(task):
    recogniser, picture = task
    return [answer.to_dict() for answer in recogniser.recognise_batch([picture] * 3, threads=2)]


@needs_fork
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_goes_on_with_everything(index, queries, vectors, recogniser, tmp_path):
    # All that might leave threads or locks behind in this process.
    expected = index.search(queries, threads=2)[0]
    grasp.build(vectors, tmp_path / "parent.idx", threads=2)
    (answer,) = recogniser.recognise_batch([CAMERA], threads=2)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            same = (index.search(queries, threads=2)[0] == expected).all()
            rebuilt = grasp.build(vectors, tmp_path / "child.idx", threads=2)
            same &= (tmp_path / "child.idx").read_bytes() == (tmp_path / "parent.idx").read_bytes()
            same &= len(rebuilt) == len(vectors)
            (again,) = recogniser.recognise_batch([CAMERA], threads=2)
            same &= again.to_dict() == answer.to_dict()
            os.write(writer, b"same" if same else b"different")
            status = 0
        finally:
            os._exit(status)
    os.close(writer)
    deadline = time.monotonic() + 120
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        if time.monotonic() > deadline:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            pytest.fail("the forked process waits for something that is not there")
        time.sleep(0.01)
    assert os.read(reader, 100) == b"same"
    os.close(reader)


def test_a_spawned_process_opens_the_index_again(index, queries, recogniser):
    expected = index.search(queries)[0]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        (found,) = pool.map(search_in_child, [(index, queries)])
        (answers,) = pool.map(recognise_in_child, [(recogniser, CAMERA)])
    assert (found == expected).all()
    assert answers == [recogniser.recognise(CAMERA).to_dict()] * 3


@needs_fork
def test_ctrl_c_stops_a_build(tmp_path):
    script = (
        "import numpy, os, signal, threading, grasp\n"
        # Whoever runs the tests in the background may have it ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "x = numpy.random.default_rng(0).normal(size=(200_000, 64)).astype('f4')\n"
        "threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        f"try: grasp.build(x, {str(tmp_path / 'long.idx')!r})\n"
        "except KeyboardInterrupt: print('stopped')\n"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300)
    assert ended.stdout == "stopped\n", ended.stderr
    assert not (tmp_path / "long.idx").exists()
