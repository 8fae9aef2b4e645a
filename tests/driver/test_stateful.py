"""Driver, arm and operator under any sequence of troubles; the long version is a benchmark."""

from hypothesis import HealthCheck, Phase, settings

from tests.driver.driven_arm import DrivenArm

DrivenArm.TestCase.settings = settings(
    max_examples=8,
    stateful_step_count=25,
    deadline=None,
    phases=(Phase.generate,),  # a failing run is short enough; shrinking it takes minutes
    derandomize=True,
    database=None,
    report_multiple_bugs=False,
    suppress_health_check=list(HealthCheck),
)
TestDrivenArm = DrivenArm.TestCase
