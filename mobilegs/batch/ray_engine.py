"""The engine on a Ray cluster: each task is a Ray task that starts a process on its machine.

Whoever can reach a cluster without token authentication can run programs on it.
"""

import logging
import os
import time
from typing import Any

from mobilegs.batch.engine import Node
from mobilegs.batch.task import GRACE_SECONDS, Outcome, Task, run_task
from mobilegs.errors import InputError
from mobilegs.extras import extra_module

SUBMITTED_SHARE = 1.25  # of the cluster, so that no machine waits for the batch


def _run(line: str) -> tuple[str, str]:
    """Run a task on a machine of the cluster; plain values need no code of ours to be read."""
    outcome = run_task(Task.from_json(line))
    return outcome.result, outcome.message


class RayEngine:
    """An `Engine` that runs tasks on the Ray cluster of RAY_ADDRESS or of this machine."""

    def __init__(self) -> None:
        """Join the cluster, with token authentication unless RAY_AUTH_MODE says otherwise.

        Raises InputError if Ray is not installed, and if there is no cluster or it takes no token.
        """
        os.environ.setdefault("RAY_AUTH_MODE", "token")
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # sends nothing to anybody
        # a task without GPUs sees none, also in later versions of Ray
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "1")
        self._ray = ray = extra_module("ray", "--engine ray needs Ray", "batch")
        address = os.environ.get("RAY_ADDRESS") or "auto"
        where = "on this machine" if address == "auto" else f"at {address} (RAY_ADDRESS)"
        try:
            ray.init(address, log_to_driver=False, logging_level=logging.CRITICAL)
        except ConnectionError:
            raise InputError(
                f"no Ray cluster answers {where}: start one with `ray start --head` and the token "
                "of this machine"
            ) from None
        except ray.exceptions.AuthenticationError:
            raise InputError(
                f"the Ray cluster {where} needs a token: copy ~/.ray/auth_token from its first "
                "machine, where `ray get-auth-token --generate` makes it"
            ) from None
        self.name = f"Ray {ray.__version__}"
        self._function = ray.remote(_run)
        self._running: dict[Any, Task] = {}

    def nodes(self) -> list[Node]:
        alive = [
            Node(node["NodeName"], int(own.get("CPU", 0)), int(own.get("GPU", 0)))
            for node in self._ray.nodes()
            if node["Alive"] and (own := node["Resources"])
        ]
        return [node for node in alive if node.cores]  # a head may leave the work to others

    def accepts(self, task: Task) -> bool:
        nodes = self.nodes()
        cores = sum(other.cores for other in self._running.values())
        gpus = sum(other.gpus for other in self._running.values())
        if task.gpus:
            return gpus < max(1, SUBMITTED_SHARE * sum(node.gpus for node in nodes))
        return cores < max(1, SUBMITTED_SHARE * sum(node.cores for node in nodes))

    def submit(self, task: Task) -> None:
        options = {"num_cpus": task.cores, "num_gpus": task.gpus, "max_retries": 0}
        function = self._function.options(scheduling_strategy="SPREAD", **options)
        self._running[function.remote(task.as_json())] = task

    def ended(self, seconds: float) -> list[tuple[Task, Outcome]]:
        if not self._running:
            time.sleep(seconds)
            return []
        references, _ = self._ray.wait(list(self._running), timeout=seconds)
        return [(self._running.pop(each), self._outcome(each)) for each in references]

    def _outcome(self, reference: Any) -> Outcome:
        """Return the outcome of a Ray task that ended, also of one whose machine died."""
        from ray import exceptions

        try:
            result, message = self._ray.get(reference)
        except exceptions.TaskCancelledError:
            return Outcome("stopped", "it was stopped")
        except exceptions.NodeDiedError:
            return Outcome("lost", "its machine died")
        except exceptions.WorkerCrashedError:
            return Outcome("lost", "its machine or its process died")
        except exceptions.RayError as error:
            return Outcome("lost", (str(error).strip().splitlines() or [repr(error)])[-1])
        return Outcome(result, message)

    def stop(self) -> None:
        for reference in self._running:
            self._ray.cancel(reference)
        if self._running:
            self._ray.wait(
                list(self._running), num_returns=len(self._running), timeout=GRACE_SECONDS
            )
        self._running = {}

    def close(self) -> None:
        self._ray.shutdown()
