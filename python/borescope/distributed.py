"""Campaigns and fleets on many machines, with Dask as the engine.

Work is done in shards (``docs/how-to/run-a-campaign.md``): each is a piece that one worker does alone, in a folder of its own that all machines see, and
that ends at once where it is done already. So a worker, the scheduler or this program may die at any time: the same call goes on with
what is there, and nothing is counted twice. Results are files; what goes through Dask is the number of a shard.

    from dask.distributed import Client
    from borescope.distributed import campaign, diagnose_fleet

    campaign(Client("tcp://head:8786"), "rig.toml", 100_000, out="/shared/campaign")
"""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

from borescope._borescope import __version__
from borescope._complaint import Complaint, call, call_all
from borescope._files import write
from borescope._fleet import Errand, ListLike, do, local
from borescope._result import Result
from borescope._rig import Rig, rig_file_in

#: Called with how many shards are done, and of how many.
Done = Callable[[int, int], object]

#: Shards that are with the scheduler at a time, for each thread of a worker: the next ones are there when one is done.
_WINDOW = 3
#: Shards for each thread of a worker, so that the last ones do not keep the others waiting.
_EACH = 10
#: Least of both: a cluster that grows with its work may have no worker when it is asked, and does not grow for a few shards.
_LEAST = 100
#: Most shards of one work.
_MOST = 99_999
#: Most tasks in which records at addresses are brought.
_MOST_ERRANDS = 1000
#: How often it is looked whether a shard is done, or the scheduler gone, in seconds.
_LOOK = 0.02
#: How often it is asked how large the cluster is, in seconds.
_AGAIN = 1.0
#: States of a client that has a scheduler, or still looks for it.
_ALIVE = ("running", "connecting")


def campaign(
    client: Any,
    rig: Rig | str | os.PathLike[str],
    cases: int,
    out: str | os.PathLike[str],
    *,
    seed: int = 1,
    rigs: int | None = None,
    disturbance: float = 1.0,
    shards: int | None = None,
    retries: int = 10,
    progress: Done | None = None,
) -> Result:
    """Measures the diagnosis of a rig on synthetic faults: ``borescope.campaign/1``, as one process would give it but for times.

    ``out`` is a folder that all workers see under the same path. ``shards`` without a number is ten for each thread of the workers, at
    least 100, and at most one for each disturbed rig; a call that goes on with an earlier one keeps its number. A shard whose worker
    dies is given to another, ``retries`` times at most.
    """
    folder = Path(out)
    words = ["campaign", _rig_file(rig, folder), "--cases", str(cases), "--seed", str(seed)]
    words += ["--disturbance", str(disturbance), "--threads", "1", "-o", str(folder / "shards")]
    words += [] if rigs is None else ["--rigs", str(rigs)]
    count = _shards(client, folder, shards, rigs or max(cases // 25, 1))
    _work_shards(client, words, count, retries, progress)
    merged = folder / "merged"
    text = call(["campaign", "--merge", str(folder / "shards"), "-o", str(merged), "--force", "--format", "json"])
    return Result(text)


def diagnose_fleet(
    client: Any,
    rig: Rig | str | os.PathLike[str],
    manifest: ListLike,
    out: str | os.PathLike[str],
    *,
    table: str | os.PathLike[str] | None = None,
    shards: int | None = None,
    retries: int = 10,
    progress: Done | None = None,
) -> Result:
    """Diagnoses the records that a list names, into ``table`` (CSV or Parquet; ``fleet.parquet`` in ``out`` without one): ``borescope.records/1``.

    ``manifest`` is the path of a list, a pattern such as ``"s3://rigs/2026/*.mf4"``, or a sequence of paths and addresses; records at
    addresses are brought into ``out`` by the workers first. Records without a diagnosis are in ``.failures``. Workers see ``out``, the list
    and its records under the same paths. ``shards`` without a number is ten for each thread of the workers, at least 100.
    """
    folder = Path(out)

    def fetched(errands: Sequence[Errand]) -> list[str]:
        wrong: list[str] = []
        pieces = [errands[at::_MOST_ERRANDS] for at in range(min(_MOST_ERRANDS, len(errands)))]
        _work(client, lambda index: (do, pieces[index - 1]), len(pieces), retries, None, wrong.extend)
        return wrong

    words = ["diagnose", _rig_file(rig, folder), "--records", local(manifest, folder, fetched), "--threads", "1"]
    count = _shards(client, folder, shards, _MOST)
    _work_shards(client, [*words, "-o", str(folder / "shards")], count, retries, progress)
    into = os.fspath(table or folder / "fleet.parquet")
    return Result(call(["diagnose", "--merge", str(folder / "shards"), "-o", into, "--force", "--format", "json"]))


def _rig_file(rig: Rig | str | os.PathLike[str], folder: Path) -> str:
    """The rig file beside the shards, where all workers see it."""
    return rig_file_in(rig if isinstance(rig, Rig) else Rig(rig), folder)


def _shards(client: Any, folder: Path, asked: int | None, most: int) -> int:
    """How many shards the work in a folder has; kept there, as another cluster that goes on with it may be of another size."""
    path = folder / "shards.json"
    if path.exists():
        kept = int(json.loads(path.read_text(encoding="utf-8"))["shards"])
        if asked not in (None, kept):
            raise Complaint(
                f"the work in the folder is in {kept} shards, not {asked}",
                file=str(path),
                remedy="leave `shards` away to go on with it, or name another folder",
            )
        return kept
    count = asked or min(max(_EACH * _threads(client), _LEAST), most, _MOST)
    write(path, json.dumps({"shards": count}) + "\n")
    return count


def _threads(client: Any) -> int:
    """Threads of all workers that are there now."""
    return sum(client.nthreads().values())


def _shard(words: Sequence[str], index: int, of: int, version: str) -> Complaint | None:
    """Does a shard, on a worker; gives what is wrong where it cannot be done."""
    # Shards of two versions cannot be merged: better told before the first one than after the last.
    if version != __version__:
        return Complaint(
            f"the worker on {platform.node()} has version {__version__} of the package, and this program has {version}",
            remedy="install the same version on all workers; then the same call goes on with what is done",
        )
    done, wrong = call_all([*words, "--shard", f"{index}/{of}"], threads=1)
    # Of records some may be damaged: they are in the journal, and the shard is done.
    return wrong[0] if wrong and not done else None


def _work_shards(client: Any, words: Sequence[str], of: int, retries: int, progress: Done | None) -> None:
    words = [str(Path(word).resolve()) if before == "-o" else word for before, word in zip(["", *words], words)]

    def take(wrong: Complaint | None) -> None:
        if wrong is not None:
            raise wrong

    _work(client, lambda index: (_shard, words, index, of, __version__), of, retries, progress, take)


def _lost() -> Complaint:
    return Complaint(
        "the scheduler of Dask does not answer any more",
        remedy="start it again, or another one, with workers; the same call with a client of it goes on with what is done",
    )


def _finished(client: Any, flow: Any) -> Iterator[Any]:
    """Futures as they finish. Dask waits for ever where the scheduler has died."""
    while flow.count():
        if flow.has_ready():
            yield next(flow)
        elif client.status not in _ALIVE:
            raise _lost()
        else:
            time.sleep(_LOOK)


def _work(
    client: Any,
    task: Callable[[int], tuple[Any, ...]],
    of: int,
    retries: int,
    progress: Done | None,
    take: Callable[[Any], None],
) -> None:
    """Has tasks 1 to ``of`` done, each a function and its arguments, and gives their results to ``take``."""
    import distributed

    # Dask says nothing of its types.
    as_completed: Any = distributed.as_completed
    waiting, tries, done = list(range(of, 0, -1)), dict.fromkeys(range(1, of + 1), 0), 0
    of_future: dict[str, int] = {}

    def submit() -> Any:
        if client.status not in _ALIVE:
            raise _lost()
        index = waiting.pop()
        # What a shard leaves are files, so that its result is never taken from another call.
        function, *arguments = task(index)
        future = client.submit(function, *arguments, pure=False, retries=0)
        of_future[future.key] = index
        return future

    flow, window, again = as_completed([]), 0, 0.0

    def fill() -> None:
        """Keeps a window of work with the scheduler, as wide as the cluster is now."""
        nonlocal window, again
        if waiting and time.monotonic() > again:
            try:
                window = max(_WINDOW * _threads(client), _LEAST)
            except OSError:
                raise _lost() from None
            again = time.monotonic() + _AGAIN
        while waiting and flow.count() < window:
            flow.add(submit())

    fill()
    try:
        for future in _finished(client, flow):
            index = of_future.pop(future.key)
            if future.status == "finished":
                try:
                    result = future.result()
                except CancelledError:
                    # The scheduler died between the end of the task and the question for its result.
                    raise _lost() from None
                take(result)
                done += 1
                if progress is not None:
                    progress(done, of)
            elif client.status != "running":
                # Dask cancels what it cannot ask for any more: no worker is to blame.
                raise _lost()
            else:
                tries[index] += 1
                if tries[index] > retries:
                    raise Complaint(
                        f"shard {index} of {of} was given up after {tries[index]} workers: {future.exception()}",
                        remedy="look at the logs of the workers; the same call goes on with what is done",
                    )
                waiting.append(index)
            future.release()
            fill()
    finally:
        # Ctrl-C leaves no work behind.
        if client.status == "running":
            client.cancel(list(flow.futures))
