"""The arm, who takes part, and how much is measured."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from services.experiments.ik.arm import Arm, measured_arm
from services.experiments.ik.contenders import Contender, Nothing, Ours
from services.experiments.ik.field import everybody, ours, reference
from services.experiments.ik.poses import OURS
from services.experiments.ik.sets import SHORT, Sizes
from services.experiments.rows import Row


@dataclass(frozen=True, eq=False)
class Setting:
    """What all parts of the benchmark share."""

    arm: Arm  # of the published figures
    seed: int
    short: bool
    say: Callable[[str], None]
    contenders: list[Contender]
    missing: list[Row]

    @property
    def sizes(self) -> Sizes:
        """How many targets."""
        return SHORT if self.short else Sizes()

    def ticks(self, count: int) -> int:
        """How long a path."""
        return count // 5 if self.short else count

    def ours(self) -> Ours:
        """The default solver."""
        return next(c for c in self.contenders if isinstance(c, Ours) and c.name == OURS)

    def labelled(self, row: Row) -> Row:
        """The row with the seed in its name."""
        return replace(row, name=f"seed {self.seed}: {row.name}")


def setting(seed: int, short: bool, say: Callable[[str], None]) -> Setting:
    """Everybody; the short run leaves the peers out."""
    arm = measured_arm()
    if short:
        why = "not measured in a short run"
        return Setting(
            arm,
            seed,
            short,
            say,
            [Nothing(), *ours(arm)[:1], reference(arm)],
            [Row("peers", None, "", why)],
        )
    contenders, missing = everybody(arm)
    return Setting(arm, seed, short, say, contenders, missing)
