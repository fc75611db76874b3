"""The real right arm against its bars: CAD, another generation's CAD, identified parameters."""

from pathlib import Path

from services.experiments.forces import icubdyn
from services.experiments.forces.arm_learning import ArmTask, load_task
from services.experiments.forces.identified_arm import identified_nmse
from services.experiments.forces.wrench_errors import COMPONENTS, UNITS, Comparison, of_recording
from services.experiments.rows import Row, at_least, at_most

RIGHT, WRONG = "iCubLisboa01", "iCubGazeboV2_5"
BARS = (0.80, 0.72, 0.40, 0.070, 0.058, 0.050)  # std of the errors: N, Nm
WORSE = 3.0  # times the error, by which a model of another generation is found out
IDENTIFIED_NMSE = 0.0170


def is_at_hand(data: Path | None) -> bool:
    """Whether the recording is named, or is where it is looked for."""
    return data is not None or icubdyn.is_here()


def absent() -> Row:
    """Stands in the place of the rows where there is no recording."""
    where = f"not here; --data FILE names it ({icubdyn.SOURCE})"
    return Row("recording of a real right arm", where)


def recorded_rows(data: Path | None = None) -> list[Row]:
    """All rows, or the one that says that the recording is not here.

    Raises:
        ConfigError: `data` is not the recording.
    """
    if not is_at_hand(data):
        return [absent()]
    recording = icubdyn.load(data)
    return bars(of_recording(recording, RIGHT), recording, load_task(data))


def bars(right: Comparison, recording: icubdyn.Recording, task: ArmTask) -> list[Row]:
    """The rows of one reading of the recording; `right` is by the drawing of RIGHT."""
    rows = [
        at_most(f"right_arm, recorded: {component}, std", float(right.std[i]), UNITS[i], BARS[i])
        for i, component in enumerate(COMPONENTS)
    ]
    wrong = of_recording(recording, WRONG)
    once, online = identified_nmse(task)
    return [
        *rows,
        Row(f"right_arm, recorded: nMSE of {WRONG}", wrong.nmse),
        at_least(f"nMSE of {WRONG} against {RIGHT}", wrong.nmse / right.nmse, "times", WORSE),
        at_most("nMSE, parameters identified on the training rows", once, "", IDENTIFIED_NMSE),
        at_most("nMSE, parameters identified online", online, "", IDENTIFIED_NMSE),
    ]
