"""What a solver may be told."""

import pytest

from armsyn.editing import SolverOptions
from armsyn.errors import InputError


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"iterations": 0}, "0 iterations"),
        ({"damping": -1.0}, "damping -1"),
        ({"damping": float("nan")}, "damping nan"),
        ({"damping_unit": "inch"}, "damping unit 'inch': relative, metre, centimetre"),
        ({"tolerance": float("nan")}, "tolerance nan is not positive"),
        ({"longest": 0.0}, "longest 0 is not positive"),
        ({"pull": 1.5}, "pull 1.5 is not in"),
        ({"toward_coefficients": (float("inf"),)}, "finite"),
    ],
)
def test_options_out_of_range(options: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        SolverOptions(**options)  # type: ignore[arg-type]


def test_the_papers_xi_is_in_centimetres() -> None:
    assert SolverOptions.paper(0.8).as_damping == (0.008, False)
    assert SolverOptions(damping=0.1).as_damping == (0.1, True)
