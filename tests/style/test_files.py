"""House rules about files that the linter cannot see."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("services", "hal", "dforc", "firmware_sim")
CODE = sorted(p for name in PACKAGES for p in (ROOT / name).rglob("*.py"))
ALL_CODE = CODE + sorted(p for name in ("tests", "benchmarks") for p in (ROOT / name).rglob("*.py"))

MOST_LINES = 400
MOST_METHODS = 15
NAMES_THAT_SAY_NOTHING = {"utils", "util", "common", "helpers", "helper", "constants", "misc"}
# A plain python-can tool that opens the Zenoh bus has no clock to give it.
TIME_READERS = ["hal/buses/zenoh.py", "services/core/clock.py"]


def relative(path: Path) -> str:
    return str(path.relative_to(ROOT))


def imported(tree: ast.AST) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
    return names


def test_finds_the_four_packages() -> None:
    assert {path.relative_to(ROOT).parts[0] for path in CODE} == set(PACKAGES)


def test_file_names_say_what_is_inside() -> None:
    assert [relative(p) for p in ALL_CODE if p.stem in NAMES_THAT_SAY_NOTHING] == []


def test_packages_have_no_code_of_their_own() -> None:
    inits = [path for path in CODE if path.name == "__init__.py"]
    assert [relative(path) for path in inits if path.read_text().strip()] == []


def test_every_package_folder_has_an_init_file() -> None:
    folders = {path.parent for path in CODE}
    assert [relative(f) for f in sorted(folders) if not (f / "__init__.py").is_file()] == []


def test_test_folders_are_no_packages() -> None:
    # tests/services/__init__.py would make pytest find the test folder as `services`
    assert [relative(p) for p in (ROOT / "tests").rglob("__init__.py")] == []


def test_files_are_short() -> None:
    lengths = {relative(path): len(path.read_text().splitlines()) for path in ALL_CODE}
    assert {name: lines for name, lines in lengths.items() if lines > MOST_LINES} == {}


def test_only_the_clock_file_reads_time() -> None:
    readers = [relative(p) for p in ALL_CODE if "time" in imported(ast.parse(p.read_text()))]
    assert readers == TIME_READERS


def test_classes_are_small() -> None:
    large = {}
    for path in CODE:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef):
                methods = [
                    item.name
                    for item in node.body
                    if isinstance(item, ast.FunctionDef)
                    and not item.name.startswith("_")
                    and not item.decorator_list  # a property is no method to a reader
                ]
                if len(methods) > MOST_METHODS:
                    large[f"{relative(path)}: {node.name}"] = len(methods)
    assert large == {}


@pytest.mark.parametrize("word", ["TODO", "FIXME", "XXX", "noqa: F", "type: ignore\n"])
def test_nothing_is_left_for_later(word: str) -> None:
    assert [relative(p) for p in CODE if word in p.read_text()] == []


def test_one_broad_except_in_the_project() -> None:
    """All others say what they expect, or only add a note and raise again."""
    broad = []
    for path in CODE:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ExceptHandler):
                kind = ast.unparse(node.type) if node.type else "BaseException"
                raises_again = isinstance(node.body[-1], ast.Raise) and node.body[-1].exc is None
                if kind in {"Exception", "BaseException"} and not raises_again:
                    broad.append(relative(path))
    assert broad == ["services/core/live.py"]
