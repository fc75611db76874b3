"""What a user can mend is said in one way, whichever verb says it."""

import pytest

from services.cli.main import main

NOBODY = "--robot nobody"
NOWHERE = "--stack nowhere"


@pytest.mark.parametrize(
    "line",
    [
        f"board list {NOBODY}",
        f"board run --bus 0 --address 3 {NOBODY}",
        f"board fault freeze {NOWHERE}",
        f"board fault freeze --identifier xyz {NOWHERE}",
        f"can scan {NOBODY}",
        f"demo reach {NOBODY}",
        f"dynamics status {NOWHERE}",
        f"up {NOBODY}",
    ],
)
def test_every_verb_complains_in_the_name_of_the_command(
    line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(line.split()) == 2

    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert said[0].startswith("ulna: ")
