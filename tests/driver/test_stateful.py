"""Driver, arm and operator under any sequence of troubles; the long version is a benchmark."""

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.driver.driven_arm import DrivenArm

SHORT = settings(
    max_examples=8,
    stateful_step_count=30,
    deadline=None,
    phases=(Phase.generate,),  # shrinking takes minutes, and thirty steps are read without
    derandomize=True,
    database=None,
    report_multiple_bugs=False,
    suppress_health_check=list(HealthCheck),
)


@pytest.mark.fault(11)
def test_any_sequence_of_troubles() -> None:
    run_state_machine_as_test(DrivenArm, settings=SHORT)
    assert DrivenArm.seen["runs"] > 0
    assert DrivenArm.seen["mended"] > 0
