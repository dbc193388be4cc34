"""Serves the segments of an index from a Ray cluster, as one service at one address.

    python serve.py /shared/segments/*-of-4.idx --port 8750
    grasp-query search queries.npy --server http://127.0.0.1:8750 --out ids.npy

The segments (`grasp-builder split`, or `merge --segments`) lie where every node finds them; grasp-query is in the PATH of each. Each
segment is mapped by a `grasp-query serve` of its own, next to the replica that asks it. The answers are exactly those of the whole
index, at any effort. A service, replica or node that is lost is started again elsewhere, and requests wait for it; those that have
waited --patience seconds fail (status 503), or with --allow-missing (for one request: `?allow_missing=true`) are answered by the other
segments, as the header `Grasp-Segments: 3/4` says.
"""

import argparse
import asyncio
import ctypes
import http.client
import json
import re
import signal
import socket
import subprocess
import tempfile
import time
import urllib.parse

import ray
from ray import serve
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response

EFFORT = {"recall", "eps", "success", "probes", "exact"}


class Connection(http.client.HTTPConnection):
    """HTTP by a path."""

    def __init__(self, path):
        super().__init__("localhost", timeout=60)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


@serve.deployment(health_check_period_s=1, health_check_timeout_s=5, graceful_shutdown_timeout_s=5)
class Segment:
    """A segment, and the service that answers for it."""

    def __init__(self, path):
        self.folder = tempfile.TemporaryDirectory()
        self.socket = f"{self.folder.name}/s"
        die_with_us = ctypes.CDLL(None).prctl
        self.service = subprocess.Popen(
            ["grasp-query", "serve", "--index", path, "--unix", self.socket],
            preexec_fn=lambda: die_with_us(1, signal.SIGKILL),  # PR_SET_PDEATHSIG
        )
        while not self.is_ready():
            self.check_health()
            time.sleep(0.05)
        self.index = json.loads(self.exchange("GET", "/v1/index")[1])
        is_of = re.search(r"entries (\d+) to \d+ of (\d+)", dict(self.index["provenance"]).get("segment", ""))
        if not is_of:
            raise ValueError(f"{path} is no segment: `grasp-builder split` writes them")
        self.start, self.index["of"] = int(is_of[1]), int(is_of[2])

    def exchange(self, method, target, body=None):
        connection = Connection(self.socket)
        try:
            connection.request(method, target, body)
            answer = connection.getresponse()
            return answer.status, answer.read()
        finally:
            connection.close()

    def is_ready(self):
        try:
            return self.exchange("GET", "/readyz")[0] == 200
        except OSError:
            return False

    def check_health(self):
        if self.service.poll() is not None:
            raise RuntimeError(f"its service has ended with status {self.service.returncode}")

    async def describe(self):
        self.check_health()
        return self.index

    async def shortlists(self, query, body):
        """Its index, and for each descriptor the shortlist, numbered as in the whole index; or the status and body of a refusal."""
        status, answer = await asyncio.to_thread(self.exchange, "POST", f"/v1/search?{query}&shortlist=true", body)
        if status != 200:
            return None, (status, answer)
        # Distances stay the text that they are.
        found = [json.loads(line, parse_float=str) for line in answer.splitlines()]
        for shortlist in found:
            for near in shortlist["neighbours"]:
                near["id"] += self.start
        return self.index, found

    def __del__(self):
        if hasattr(self, "service"):
            self.service.terminate()


def lacks(shortlists, wanted):
    """Whether a search of the whole index would look into more buckets."""
    first = shortlists[0]
    found = sum(len(shortlist["neighbours"]) for shortlist in shortlists)
    return "probes" in first and found < wanted


def merged(shortlists, k):
    """The k nearest of those candidates that a search of the whole index would measure."""
    near = [near for shortlist in shortlists for near in shortlist["neighbours"]]
    near.sort(key=lambda near: (near["key"], near["id"]))
    near = near[: shortlists[0].get("keep")]
    near.sort(key=lambda near: (float(near["distance"]), near["id"]))
    return near[:k]


def line(query, found):
    """As grasp-query writes it."""

    def record(near):
        names = [f',"{key}":{json.dumps(near[key], ensure_ascii=False)}' for key in ("grasp", "file") if key in near]
        return f'{{"id":{near["id"]},"distance":{near["distance"]}{"".join(names)}}}'

    return f'{{"query":{query},"neighbours":[{",".join(map(record, found))}]}}\n'


def problem(status, kind, message):
    return JSONResponse({"error": {"kind": kind, "message": message}}, status)


class Missing(Exception):
    """Segments do not answer."""


@serve.deployment(max_ongoing_requests=64)
class Ingress:
    """All segments as one service."""

    def __init__(self, segments, allow_missing, patience):
        self.segments, self.allow_missing, self.patience = segments, allow_missing, patience

    async def ask_one(self, segment, method, *arguments):
        """Asks again and again: a replica that is lost comes back."""
        while True:
            try:
                return await getattr(segment, method).remote(*arguments)
            except Exception:
                await asyncio.sleep(0.2)

    async def ask(self, allow_missing, method, *arguments):
        """The answers of all segments, in order; of those that answer in time, where some may be missing."""
        asked = [asyncio.ensure_future(self.ask_one(segment, method, *arguments)) for segment in self.segments]
        done, late = await asyncio.wait(asked, timeout=self.patience)
        for task in late:
            task.cancel()
        if not done or late and not allow_missing:
            raise Missing(f"{len(done)} of {len(asked)} segments answer: try again later")
        return [task.result() for task in asked if task in done]

    async def search(self, request):
        body, asked = await request.body(), dict(urllib.parse.parse_qsl(request.url.query))
        k = int(asked.get("k", 10))
        allow_missing = asked.pop("allow_missing", str(self.allow_missing)).lower() == "true"
        found, searched = {}, len(self.segments)
        while True:
            answers = await self.ask(allow_missing, "shortlists", urllib.parse.urlencode(asked), body)
            searched = min(searched, len(answers))
            for index, refused in answers:
                if index is None:
                    return Response(refused[1], refused[0], media_type="application/json")
            wanted = min(k, self.entries([index for index, _ in answers], allow_missing))
            short = False
            for query, shortlists in enumerate(zip(*(answer for _, answer in answers))):
                if query in found:
                    continue
                if lacks(shortlists, wanted):
                    short, probes = True, shortlists[0]["probes"]
                    most = shortlists[0]["most_probes"]
                else:
                    found[query] = merged(shortlists, k)
            if not short:
                break
            # As a search of one index does.
            asked = {key: value for key, value in asked.items() if key not in EFFORT}
            asked |= {"probes": 2 * probes} if probes < most else {"exact": "true"}
        lines = "".join(line(query, found[query]) for query in sorted(found))
        headers = {"Grasp-Segments": f"{searched}/{len(self.segments)}"}
        return Response(lines, media_type="application/x-ndjson", headers=headers)

    def entries(self, indexes, allow_missing):
        """How many entries they hold: all, unless some may be missing."""
        held, of = sum(index["entries"] for index in indexes), indexes[0]["of"]
        if held != of and not allow_missing:
            raise Missing(f"the segments hold {held} of {of} entries: serve all segments of one index")
        return held

    async def index(self):
        indexes = await self.ask(self.allow_missing, "describe")
        segments = {"searched": len(indexes), "of": len(self.segments)}
        whole = {key: sum(index[key] for index in indexes) for key in ("entries", "bytes")}
        return JSONResponse(indexes[0] | whole | {"segments": segments})

    async def ready(self):
        indexes = await self.ask(self.allow_missing, "describe")
        return JSONResponse({"ready": True, "segments": {"searched": len(indexes), "of": len(self.segments)}})

    async def __call__(self, request: Request):
        try:
            match request.method, request.url.path:
                case "POST", "/v1/search":
                    return await self.search(request)
                case "GET", "/v1/index":
                    return await self.index()
                case "GET", "/readyz":
                    return await self.ready()
                case "GET", "/healthz":
                    return PlainTextResponse("ok\n")
        except Missing as missing:
            return problem(503, "segments", str(missing))
        except ValueError as error:
            return problem(400, "request", str(error))
        return problem(404, "not_found", "segments answer POST /v1/search, GET /v1/index, /healthz and /readyz")


def start(segments, host, port, replicas, allow_missing, patience):
    """Serves from the cluster that this program is connected to, and returns when all segments are there."""
    serve.start(http_options={"host": host, "port": port, "location": "HeadOnly"})
    options = {"num_replicas": replicas, "ray_actor_options": {"num_cpus": 0.1}}
    bound = [Segment.options(name=f"segment-{at}", **options).bind(path) for at, path in enumerate(segments, 1)]
    # Beside the proxy, so that what is under way outlives every other node.
    at_head = {"num_cpus": 0, "resources": {"node:__internal_head__": 0.001}}
    ingress = Ingress.options(ray_actor_options=at_head).bind(bound, allow_missing, patience)
    serve.run(ingress, name="grasp", route_prefix="/")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("segments", nargs="+", help="the segments' files, all of one index")
    parser.add_argument("--address", help="the cluster, as ray.init takes it; without it, the one of RAY_ADDRESS or a local one")
    parser.add_argument("--host", default="127.0.0.1", help="where the head node listens; who can reach it can ask")
    parser.add_argument("--port", type=int, default=8750)
    parser.add_argument("--replicas", type=int, default=1, help="of each segment")
    parser.add_argument("--allow-missing", action="store_true")
    parser.add_argument("--patience", type=float, default=60.0, metavar="SECONDS")
    arguments = parser.parse_args()
    ray.init(address=arguments.address)
    try:
        start(**{key: value for key, value in vars(arguments).items() if key != "address"})
        while True:
            time.sleep(3600)
    except KeyboardInterrupt:
        pass
    finally:
        serve.shutdown()


if __name__ == "__main__":
    main()
