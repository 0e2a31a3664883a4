"""A scheduler and workers of Dask as processes that can be killed like those of a cluster."""

import os
import signal
import socket
import subprocess
import sys
import time


def _free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Processes:
    """A scheduler and so many workers, each a process of its own; workers that end are replaced, as a batch system does."""

    def __init__(self, workers):
        self.port = _free_port()
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.count = workers
        self.workers = []
        self.scheduler = None

    def _start(self, what, *words):
        command = [sys.executable, "-m", "distributed.cli.dask_" + what, *words]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def start_scheduler(self):
        self.scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard", "--no-show"
        )
        for _ in range(300):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.1)
        raise TimeoutError("the scheduler does not answer")

    def start_worker(self):
        # Without a nanny: what is killed stays dead until somebody starts another.
        words = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "20"]
        self.workers.append(self._start("worker", self.address, *words))

    def __enter__(self):
        self.start_scheduler()
        for _ in range(self.count):
            self.start_worker()
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
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()
