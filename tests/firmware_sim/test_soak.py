"""Short runs of `make soak` and `make fuzz`, with all seeds that ever failed."""

from pathlib import Path

import pytest

from tests.benchmarks import fuzz, soak

SEEDS = Path(__file__).resolve().parent.parent / "data" / "fuzz_seeds.txt"
FAILED_SEEDS = [
    int(line.split()[0]) for line in SEEDS.read_text().splitlines() if not line.startswith("#")
]


def test_a_short_soak_recovers_with_flat_memory() -> None:
    report = soak.soak(cycles=4_000, seed=7)
    assert len(report.struck) >= 20  # kinds of faults
    assert report.fresh > 0.5 * 7 * report.cycles
    assert report.growth < soak.GROWTH_CAP


def test_the_same_soak_is_the_same() -> None:
    one, other = soak.soak(cycles=300, seed=3), soak.soak(cycles=300, seed=3)
    assert (one.fresh, one.struck) == (other.fresh, other.struck)


@pytest.mark.parametrize("seed", [*FAILED_SEEDS, *range(40)])
def test_hostile_bytes_raise_nothing(seed: int) -> None:
    fuzz.run_case(seed)
