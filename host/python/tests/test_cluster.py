"""Campaigns and sweeps, here and on a cluster whose worker is lost."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import armbridge as ab
import pytest
from distributed import Client, LocalCluster

OVER: dict[str, list[Any]] = {"controller.r": [[5.0, 5.0], [20.0, 20.0]], "seed": [1, 2, 3]}


@pytest.fixture
def client() -> Iterator[Client]:
    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0"
    ) as cluster, Client(cluster) as client:  # type: ignore[no-untyped-call]
        yield client


def test_parts_are_the_whole_to_the_byte() -> None:
    whole = ab.campaign(range(24), chunk=24)
    assert len(whole) == 24 and len(whole.cases) == 24
    with ThreadPoolExecutor(2) as executor:
        assert ab.campaign(range(24), chunk=5, client=executor).to_json() == whole.to_json()
    with pytest.raises(ValueError, match="seed 3 is in two parts"):
        ab.campaign([3, 4, 3], chunk=1)
    with pytest.raises(ValueError, match="no JSON of a fault campaign"):
        ab.Campaign(["{}"])
    with pytest.raises(ValueError, match="at least one seed"):
        ab.campaign(range(3), chunk=0)


def test_a_campaign_survives_a_worker_that_is_killed(client: Client) -> None:
    whole = ab.campaign(range(400)).to_json()
    pids: Any = client.run(os.getpid)
    pid: int = next(iter(pids.values()))
    killed = threading.Timer(0.5, os.kill, (pid, signal.SIGKILL))
    killed.start()
    begun = time.monotonic()
    cluster = ab.campaign(range(400), client=client, chunk=5)
    assert killed.finished.is_set() and time.monotonic() - begun > 0.5
    assert cluster.to_json() == whole


def test_a_sweep_is_the_same_anywhere(client: Client) -> None:
    here = ab.sweep("demo", over=OVER)
    assert [(run["controller.r"], run["seed"]) for run in here][:2] == [([5.0, 5.0], 1), ([5.0, 5.0], 2)]
    assert len({run["peak_torque_nm"] for run in here}) > 2
    there: list[dict[str, Any]] = ab.sweep("demo", over=OVER, client=client)
    assert there == here
    assert here[4] == {
        "controller.r": [20.0, 20.0],
        "seed": 2,
        **ab.bench("demo", settings={"controller.r": [20.0, 20.0]}, seed=2),
    }
