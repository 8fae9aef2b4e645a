"""Figures to set results beside: the paper's own, and an earlier study's on the same captures.

The paper (Aubry, Julliard, Gibet 2009, section 4) gives its distances without a unit; they are
taken as centimetres, which its raw controllers' several of them bear out.
"""

from __future__ import annotations

PAPER_STEPS = {"B": -0.55, "C": -0.13, "D": -0.10}
"""Change of the mean distance from the model before, as the text to its figure 3 gives it. Whether
"13 % more" is of S_B's mean or of S_A's is left open: both readings are printed."""
PAPER_MEAN_OF_D_M = 0.0135
PAPER_LEAST_OF_C_M = 0.0090

PAPER_GAINS = {"jt": -0.34, "svd": -0.66, "njt": -0.47}
"""Change of the mean distance from S_A to S_C, the text to its figure 4."""
PAPER_MEANS_OF_C_M = {"jt": 0.0215, "svd": 0.0171, "njt": 0.0226}

GOAL_SPEED_R = 0.93
"""Correlation of the hand's speed under S_C that is wanted on garza."""

EARLIER_MEANS_M = {
    "hug_mp": {
        "svd": {"A": 0.0379, "B": 0.0258, "C": 0.0136, "D": 0.0116},
        "jt": {"A": 0.0533, "B": 0.0454, "C": 0.0214, "D": 0.0178},
        "njt": {"A": 0.0352, "B": 0.0246, "C": 0.0154, "D": 0.0131},
    },
    "garza": {
        "svd": {"A": 0.0999, "B": 0.0641, "C": 0.0435, "D": 0.0377},
        "jt": {"A": 0.0979, "B": 0.0714, "C": 0.0378, "D": 0.0304},
        "njt": {"A": 0.0772, "B": 0.0590, "C": 0.0455, "D": 0.0403},
    },
}
"""Mean over the same 14 reaches, on garza with other joint limits: differential evolution with a
small budget, lambda 2, 20 and 1 per second for SVD, J^T and NJ^T."""
