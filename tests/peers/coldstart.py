"""Opens an index, answers a query, prints the time; bench.py starts it for the column of cold starts.

    coldstart.py faiss|grasp|hnswlib|usearch INDEX QUERY.npy K
    coldstart.py hnswlib peers-work/2a/hnswlib-1b/hnswlib.index one.npy 10

Each library in the way that starts fastest: mapped where it can map, nothing imported that is not needed.
"""

import json
import sys
import time

import numpy as np


def main() -> None:
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    library, path, query_path, k = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
    query = np.load(query_path)
    if library == "faiss":
        import faiss

        started = time.perf_counter_ns()
        index = faiss.read_index(path, faiss.IO_FLAG_MMAP)
        ids = index.search(query, k)[1]
    elif library == "grasp":
        import grasp

        started = time.perf_counter_ns()
        ids = grasp.Index(path).search(query, k, threads=1)[0]
    elif library == "hnswlib":
        import hnswlib

        started = time.perf_counter_ns()
        index = hnswlib.Index(space="l2", dim=query.shape[1])
        index.load_index(path)
        index.set_ef(32)
        ids = index.knn_query(query, k=k, num_threads=1)[0]
    elif library == "usearch":
        from usearch.index import Index

        started = time.perf_counter_ns()
        ids = Index.restore(path, view=True).search(query, k, threads=1).keys
    else:
        raise SystemExit(f"{library}: no such library here")
    took = time.perf_counter_ns() - started
    print(json.dumps({"ns": took, "first": int(np.asarray(ids).ravel()[0])}))


if __name__ == "__main__":
    main()
