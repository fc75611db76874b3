"""What a user is told of pip's output."""

from pathlib import Path

import pytest

from services.cli.setup.pip_output import PipOutput, explain

LOG = Path("/checkout/.venv/setup.log")
RUN = """\
Collecting casadi==3.8.2
  Downloading casadi-3.8.2-cp311-abi3-manylinux_2_28_x86_64.whl (93.2 MB)
Collecting attrs==26.1.0
  Using cached attrs-26.1.0-py3-none-any.whl (67 kB)
Collecting scipy==1.17.1
  Using cached scipy-1.17.1-cp311-cp311-manylinux_2_27_x86_64.whl (35.3 MB)
Installing collected packages: attrs, scipy, casadi
Successfully installed attrs-26.1.0 casadi-3.8.2 scipy-1.17.1
"""


@pytest.fixture
def said() -> list[str]:
    return []


def test_names_the_large_packages_only(said: list[str]) -> None:
    output = PipOutput(said.append)
    for line in RUN.splitlines(keepends=True):
        output.feed(line)
    assert said == [
        "  casadi 3.8.2, 93 MB",
        "  scipy 1.17.1, 35 MB (already on this machine)",
        "unpacking 3 packages",
    ]


def test_tells_downloads_from_what_was_there(said: list[str]) -> None:
    output = PipOutput(said.append)
    for line in RUN.splitlines(keepends=True):
        output.feed(line)
    assert output.summary() == "93 MB downloaded in 0 s, 35 MB already on this machine"


def test_counts_files_of_a_local_index(said: list[str], tmp_path: Path) -> None:
    file = tmp_path / "pin-4.1.0-cp311-cp311-manylinux_2_28_x86_64.whl"
    file.write_bytes(bytes(6_000_000))
    output = PipOutput(said.append)
    output.feed(f"Processing {file} (from -r requirements.lock (line 7))\n")
    assert said == ["  pin 4.1.0, 6 MB (already on this machine)"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            "WARNING: Retrying ... NewConnectionError ... Temporary failure in name resolution\n"
            "ERROR: No matching distribution found for argparse-addons==0.12.0",
            "the package index cannot be reached; set-up needs the network once (behind a proxy set"
            " https_proxy, with a mirror PIP_INDEX_URL) (pip's words: /checkout/.venv/setup.log)",
        ),
        (
            "ERROR: No matching distribution found for pin==4.1.0",
            "no ready-made package of pin==4.1.0 for this machine and Python"
            " (pip's words: /checkout/.venv/setup.log)",
        ),
        (
            "ERROR: Could not install packages: [Errno 28] No space left on device",
            "the disk is full: .venv takes about 1.5 GB (pip's words: /checkout/.venv/setup.log)",
        ),
        ("surprise", "pip failed; its words are in /checkout/.venv/setup.log"),
    ],
)
def test_explains_a_failure_in_one_sentence(words: str, sentence: str) -> None:
    assert explain(words, LOG) == sentence
