"""`ulna learner` without a stack, and its table."""

import pytest
from rich.console import Console

from services.cli.learner import learner_table
from services.cli.main import main
from services.wholebody.dynamics_messages import LearnerStatus, SensorLearning


@pytest.mark.parametrize(
    "words",
    [
        ("status",),
        ("save", "a.state"),
        ("restore", "a.state"),
        ("reset",),
        ("freeze",),
        ("resume",),
    ],
)
def test_without_a_stack_it_says_how_to_start_one(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["learner", *words, "--stack", "nobody"]) == 2
    assert "start one with `ulna up`" in capsys.readouterr().err


def test_the_table_has_both_errors_of_each_sensor_and_who_is_held_back() -> None:
    sensors = (
        SensorLearning(name="l_arm_ft", updates=40, gated=False, error_n=0.061, model_error_n=0.13),
        SensorLearning(name="r_arm_ft", updates=7, gated=True, error_n=0.5, model_error_n=0.6),
    )
    console = Console(width=120)
    with console.capture() as shown:
        console.print(
            learner_table(
                LearnerStatus(stamp_ns=0, state="learning", features=200, sensors=sensors)
            )
        )
    left, right = (line for line in shown.get().splitlines() if "_arm_ft" in line)
    assert [cell.strip() for cell in left.split("│")[1:6]] == [
        "l_arm_ft",
        "40",
        "0.061",
        "0.130",
        "",
    ]
    assert "yes" in right
