"""The page of a score: whole in itself, safe with what files call themselves, and it runs."""

import dataclasses
import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from armsyn.errors import InputError
from armsyn.scoring.bands import bands_of
from armsyn.scoring.human_likeness import How
from armsyn.scoring.page import page, write_page
from armsyn.scoring.score import Score, Settings, score_motions

from .arms import reach


def made(*, bands: bool = False, name: str = "b") -> Score:
    motions = [(str(n), reach(duration=1 + n / 10)) for n in range(5)]
    found = bands_of("five", motions, How()) if bands else None
    other = dataclasses.replace(reach(swing=0.8, duration=1.3), source=name)
    return score_motions(("a", reach()), (name, other), Settings(bands=found))


class _Tags(HTMLParser):
    """Collects tags, and attributes that could load something."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.open: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.loads += [str(v) for k, v in attributes if k in ("src", "href", "data", "action")]
        if tag not in ("meta", "input", "rect", "line", "circle", "polyline", "polygon"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in ("rect", "line", "circle", "polyline", "polygon"):
            assert self.open.pop() == tag


def parsed(text: str) -> _Tags:
    tags = _Tags()
    tags.feed(text)
    assert not tags.open
    return tags


def motions_in(text: str) -> dict[str, object]:
    found = re.search(r'<script type="application/json" id="motions">(.*?)</script>', text, re.S)
    assert found is not None
    document: dict[str, object] = json.loads(found[1])
    return document


@pytest.mark.parametrize("bands", [False, True])
def test_it_is_well_formed_and_loads_nothing(bands: bool) -> None:
    text = page(made(bands=bands))
    tags = parsed(text)
    assert not tags.loads
    assert not re.search(r"url\(|@import|https?:|fetch\(|XMLHttp", text)
    assert "default-src 'none'" in text
    assert tags.tags.count("canvas") == 1
    assert "{{" not in text
    for picture in re.findall(r"<svg.*?</svg>", text, re.S):
        ElementTree.fromstring(picture)  # noqa: S314  our own text


def test_it_holds_the_figures_of_the_score() -> None:
    score = made(bands=True)
    text = page(score)
    assert f"{100 * score.comparison.held_distance:.2f} cm" in text
    for part in ("low-pass on positions, 6 Hz", "5% of the peak", "5 reaches of five", "SPARC"):
        assert part in text
    assert text.count("<polygon") == 1


def test_the_motions_in_it_are_the_scored_ones() -> None:
    score = made()
    document = motions_in(page(score))
    captured = np.array(document["captured"])
    assert captured.shape[1:] == (4, 3)
    duration = (len(captured) - 1) * document["step_s"]  # type: ignore[operator]
    expected = score.comparison.captured_profile.movement_time
    assert duration == pytest.approx(expected, abs=0.05)
    assert np.linalg.norm(captured[0, 0]) == pytest.approx(0, abs=1e-4)


def test_a_hostile_name_stays_text() -> None:
    name = '</script><script>alert("{{title}}")</script><img src=x onerror=alert(1)>'
    text = page(made(name=name))
    assert parsed(text).tags.count("script") == 2
    assert "<img" not in text
    assert "alert(&quot;{{title}}&quot;)" in text


def test_where_it_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere"):
        write_page(tmp_path / "nowhere" / "page.html", made())


NODE = shutil.which("node")
STUB = """
const text = require("fs").readFileSync(process.argv[1], "utf8");
const data = text.match(/id="motions">([\\s\\S]*?)<\\/script>/)[1];
const script = text.match(/<script>\\n([\\s\\S]*?)<\\/script>/)[1];
const handlers = {}, elements = {}, points = [];
const note = (x, y) => points.push(x, y);
const context = { moveTo: note, lineTo: note, arc: note, fillText(_, x, y) { note(x, y); } };
for (const name of ["setTransform", "clearRect", "beginPath", "stroke", "fill"])
  context[name] = () => {};
let frame = null, now = 0;
global.document = { getElementById: (id) => (elements[id] ??= {
  textContent: id === "motions" ? data : "", value: 0, clientWidth: 800, clientHeight: 400,
  getContext: () => context, addEventListener: (type, f) => (handlers[id + type] = f) }) };
global.window = { addEventListener() {} };
global.performance = { now: () => now };
global.requestAnimationFrame = (f) => (frame = f);
eval(script);
const seen = { start: elements.clock.textContent };
handlers.timeinput(elements.time.value = 1);
seen.end = elements.clock.textContent;
handlers.playclick();
now = 500;
frame(now);
seen.half = elements.clock.textContent;
const before = points.length;
handlers.scenepointermove({ buttons: 1, movementX: 30, movementY: 400 });
handlers.scenekeydown({ key: "ArrowLeft", preventDefault() {} });
handlers.scenewheel({ deltaY: -50, preventDefault() {} });
seen.drawn = points.length - before;
seen.finite = points.every(Number.isFinite);
console.log(JSON.stringify(seen));
"""


@pytest.mark.skipif(NODE is None, reason="no node to run the page's script")
def test_its_script_plays_turns_and_zooms(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    write_page(path, made())
    assert NODE is not None
    ran = subprocess.run(
        [NODE, "-e", STUB, str(path)], capture_output=True, text=True, timeout=60, check=True
    )
    seen = json.loads(ran.stdout)
    assert (seen["start"], seen["half"]) == ("0.00 s", "0.50 s")
    assert float(seen["end"].split()[0]) > 1.0
    assert seen["finite"]
    assert seen["drawn"] > 100
