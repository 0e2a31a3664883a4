"""A scheduler and workers of Dask as processes that can be killed like those of a cluster."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import distributed

#: Seconds after which something is taken to hang: a busy machine may need long to start Python.
HANGS = 600


class Processes:
    """A scheduler and so many workers, each a process of its own; workers that end are replaced, as a batch system does."""

    def __init__(self, workers):
        self.folder = tempfile.TemporaryDirectory(prefix="borescope-test-")
        # The scheduler takes a port that is free, and writes here which one.
        self.file = Path(self.folder.name) / "scheduler.json"
        self.count = workers
        self.workers = []
        self.scheduler = None

    def _start(self, what, *words):
        command = [sys.executable, "-m", "distributed.cli.dask_" + what, "--scheduler-file", str(self.file), *words]
        patient = {**os.environ, "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": f"{HANGS}s"}
        return subprocess.Popen(command, env=patient, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def start_scheduler(self):
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
        until = time.monotonic() + HANGS
        while not self.file.exists():
            if self.scheduler.poll() is not None or time.monotonic() > until:
                raise RuntimeError(f"there is no scheduler; its status is {self.scheduler.poll()}")
            time.sleep(0.05)

    def start_worker(self):
        # Without a nanny: what is killed stays dead until somebody starts another.
        words = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", str(HANGS)]
        self.workers.append(self._start("worker", *words))

    def client(self, timeout="30s"):
        """A client that knows all workers. ``timeout`` is how long it looks for a scheduler that is lost."""
        until = time.monotonic() + HANGS
        while True:
            try:
                client = distributed.Client(scheduler_file=str(self.file), timeout=timeout)
                break
            except OSError:
                # A busy scheduler may need longer for its first answer than a lost one is looked for.
                if time.monotonic() > until:
                    raise
        if self.count:
            client.wait_for_workers(self.count, timeout=HANGS)
        return client

    def __enter__(self):
        try:
            self.start_scheduler()
            for _ in range(self.count):
                self.start_worker()
        except BaseException:
            self.__exit__()
            raise
        return self

    def kill_worker(self):
        """Kills a worker by SIGKILL and starts another; gives the process number of the dead one."""
        worker = self.workers.pop(0)
        os.kill(worker.pid, signal.SIGKILL)
        worker.wait()
        self.start_worker()
        return worker.pid

    def kill_scheduler(self):
        os.kill(self.scheduler.pid, signal.SIGKILL)
        self.scheduler.wait()

    def __exit__(self, *_):
        for process in filter(None, [*self.workers, self.scheduler]):
            process.kill()
            process.wait()
        self.folder.cleanup()
