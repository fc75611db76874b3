"""The documentation tells the truth: its snippets run, and what it names is there."""

import re
from pathlib import Path

import pytest

from services.cli.main import app

ROOT = Path(__file__).parent.parent
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
FOLDERS = ("hal", "firmware_sim", "dforc", "services", "robots", "tests", "docs", "benchmarks")
PLACEHOLDER = re.compile(r"<|\bx\.py|\*|_robots$")  # services/_robots is in the wheel only


def ids(page: Path) -> str:
    return page.name


def test_the_snippets_of_the_hal_page_run_in_their_order() -> None:
    text = (ROOT / "docs" / "hal.md").read_text(encoding="utf-8")
    snippets = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len(snippets) == 10
    exec(compile("\n".join(snippets), "docs/hal.md", "exec"), {"__name__": "hal_page"})


def test_the_snippet_of_the_dynamics_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "docs" / "dynamics.md").read_text(encoding="utf-8")
    (snippet,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    exec(compile(snippet, "docs/dynamics.md", "exec"), {"__name__": "dynamics_page"})
    assert "r_upper_arm 6 6" in capsys.readouterr().out


@pytest.mark.parametrize("page", PAGES, ids=ids)
def test_every_path_named_is_there(page: Path) -> None:
    named = re.findall(rf"`((?:{'|'.join(FOLDERS)})/[^\s`]*)`", page.read_text(encoding="utf-8"))
    paths = [path for path in named if not PLACEHOLDER.search(path)]
    assert [path for path in paths if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=ids)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=ids)
def test_every_command_named_exists(page: Path) -> None:
    named = re.findall(r"`(?:\./)?ulna ([a-z]+)(?: ([a-z]+))?", page.read_text(encoding="utf-8"))
    groups = {"demo", "can", "board"}
    for verb, second in named:
        if verb in groups and second:
            assert second in app[verb], f"{page.name}: ulna {verb} {second}"
        else:
            assert verb == "setup" or verb in app, f"{page.name}: ulna {verb}"


@pytest.mark.parametrize("page", PAGES, ids=ids)
def test_every_benchmark_named_exists(page: Path) -> None:
    named = set(re.findall(r"benchmarks\.([a-z_]+)", page.read_text(encoding="utf-8")))
    assert [name for name in named if not (ROOT / "benchmarks" / f"{name}.py").exists()] == []
