"""Campaigns and sweeps over many processes or machines.

Every run is a pure function of its arguments, so that an engine that has `map` may run them
anywhere, and again if a worker is lost: a Dask client, an executor of `concurrent.futures`, or
none for this process.
"""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol

from ._native import Campaign, bench, campaign_part


class Client(Protocol):
    """An engine: `map` gives results in order, or futures that `gather` waits for, as Dask's does."""

    def map(self, function: Callable[..., Any], /, *items: Any) -> Iterable[Any]: ...


class Part:
    """A part of a campaign, as a function of its seeds."""

    def __init__(self, activity: str | None, park: bool) -> None:
        self.activity, self.park = activity, park

    def __call__(self, seeds: list[int]) -> str:
        return campaign_part(seeds, activity=self.activity, park=self.park)


def run_bench(run: Mapping[str, Any]) -> dict[str, Any]:
    """A run of a sweep: the arguments of `bench`."""
    return bench(**run)


def _results(client: Client | None, function: Callable[[Any], Any], items: list[Any]) -> list[Any]:
    if client is None:
        return [function(item) for item in items]
    results = client.map(function, items)
    gather = getattr(client, "gather", None)
    return list(gather(results) if gather else results)


def campaign(
    seeds: Iterable[int],
    *,
    client: Client | None = None,
    activity: str | None = None,
    park: bool = False,
    chunk: int = 50,
) -> Campaign:
    """Runs the fault campaign over these seeds, `chunk` of them at a time on each worker."""
    if chunk < 1:
        raise ValueError(f"expected a chunk of at least one seed, got {chunk}")
    seeds = list(seeds)
    parts = [seeds[at : at + chunk] for at in range(0, len(seeds), chunk)]
    return Campaign(_results(client, Part(activity, park), parts))


def sweep(
    scenario: str = "demo",
    *,
    over: Mapping[str, Sequence[Any]],
    client: Client | None = None,
    settings: Mapping[str, Any] | None = None,
    plant: str | None = None,
) -> list[dict[str, Any]]:
    """Runs a scenario with every combination of these values, the last key changing fastest.

    A key of `over` is a parameter of the board, `plant` or `seed`. Each result has the keys and
    their values beside the figures of `bench`.
    """
    combinations = [dict(zip(over, values)) for values in itertools.product(*over.values())]
    runs = [
        {
            "scenario": scenario,
            "plant": values.get("plant", plant),
            "seed": values.get("seed"),
            "settings": {
                **(settings or {}),
                **{key: value for key, value in values.items() if key not in ("plant", "seed")},
            },
        }
        for values in combinations
    ]
    figures = _results(client, run_bench, runs)
    return [{**values, **run} for values, run in zip(combinations, figures)]
