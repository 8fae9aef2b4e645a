"""The learners on the 14 captured reaches of HuG-MP S01: how close, for how many roll-outs.

Every learner gets the same budget of roll-outs a reach (finite differences are roll-outs too),
the paper's bounds and the same seeds. All distances are training errors: they were minimised.
Then the seconds that the default learner takes for figure 3's four models on the 14 reaches, and
for S_C on 192 reaches of two persons. ``--whole`` adds the other optimisers and S_D;
``--plot FILE`` draws the convergence.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from armsyn.arm import load_arm
from armsyn.errors import CaptureError
from armsyn.motion.captures import captures_folder, load_captures
from armsyn.synergy.learning import Fits, fit
from armsyn.synergy.options import LEARNERS, LearningOptions
from armsyn.synergy.training import Training, prepare

BUDGETS = (200, 1000, 10_000)
MODELS = ("A", "B", "C", "D")
ARM = load_arm("hug_mp4")
RATE = 120.0


def prepared(selection: str) -> list[Training]:
    """Captured reaches, put on the exoskeleton's arm."""
    return [prepare(ARM, capture, RATE) for capture in load_captures(selection)]


def learned(trainings: list[Training], ik: str, model: str, **options: object) -> Fits:
    """Learn every reach by itself, within the paper's bounds."""
    return fit(ARM, trainings, ik, model, LearningOptions(stable=False, **options))


def table(trainings: list[Training], ik: str, model: str) -> dict[str, Fits]:
    """Print one table of learners; return what they found with the largest budget."""
    print(f"S_{model} {ik}: mean best distance of {len(trainings)} reaches, cm, for a budget of")
    print(f"{'':16}" + "".join(f"{budget:>9}" for budget in BUDGETS) + f"{'s':>9}")
    largest = {}
    for learner in LEARNERS:
        began, row = time.perf_counter(), []
        for budget in BUDGETS:
            largest[learner] = learned(trainings, ik, model, learner=learner, budget=budget)
            row.append(100 * largest[learner].scores.mean())
        seconds = time.perf_counter() - began
        print(f"{learner:16}" + "".join(f"{each:9.3f}" for each in row) + f"{seconds:9.1f}")
    return largest


def plot(found: dict[str, Fits], title: str, path: Path) -> None:
    """Draw each learner's mean best distance over the roll-outs made."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    made = np.unique(np.geomspace(5, max(BUDGETS), 300).astype(int))
    for learner, fits in found.items():
        mean = [100 * fits.best_after(count).mean() for count in made]
        axes.step(made, mean, where="post", label=learner)
    axes.set(xscale="log", yscale="log", title=title)
    axes.set(xlabel="roll-outs of a reach", ylabel="mean best distance (training error), cm")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(visible=True, which="both", alpha=0.2)
    axes.legend()
    figure.savefig(path, dpi=150)


def seconds(trainings: list[Training], models: tuple[str, ...]) -> float:
    """Seconds that the default learner takes."""
    began = time.perf_counter()
    for model in models:
        learned(trainings, "svd", model)
    return time.perf_counter() - began


def main() -> int:
    """Print the tables; 1 when the default learner does not win."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--whole", action="store_true", help="every optimiser, and S_D")
    arguments.add_argument("--plot", type=Path, metavar="FILE", help="convergence, S_C svd")
    asked = arguments.parse_args()
    try:
        captures_folder()
    except CaptureError as error:
        print(f"learners: skipped, {error}")
        return 0
    trainings = prepared("hug_mp:S01")
    learned(trainings[:1], "svd", "C", budget=30)  # compiles
    pairs = [("svd", "C")]
    if asked.whole:
        pairs = [(ik, model) for model in ("C", "D") for ik in ("svd", "jt", "njt")]
    status = 0
    for ik, model in pairs:
        found = table(trainings, ik, model)
        means = {learner: fits.scores.mean() for learner, fits in found.items()}
        # What all find to a thousandth is no victory of anyone's
        status |= int(means[LEARNERS[0]] > 1.001 * min(means.values()))
        if asked.plot is not None and (ik, model) == ("svd", "C"):
            plot(found, f"S_{model} {ik}, {len(trainings)} reaches of HuG-MP S01", asked.plot)
    many = prepared("hug_mp:S01:all,hug_mp:S02:all")[:192]
    print(f"{LEARNERS[0]} with its own budget, svd, seconds for")
    print(f"  S_A to S_D of 14 reaches:{seconds(trainings, MODELS):8.1f}")
    print(f"  S_C of {len(many)} reaches:      {seconds(many, ('C',)):8.1f}")
    return status


if __name__ == "__main__":
    raise SystemExit(main())
