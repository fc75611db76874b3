"""The repository speaks of Ulna and of nothing else: not of where or by whom it was written."""

import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NOT_OURS = {"__pycache__", "LICENSE", Path(__file__).name}
ENDINGS = {".py", ".md", ".toml", ".yml", ".sh", ".cfg", ""}

FORBIDDEN = (
    r"\bissues? #?\d+\b(?<!mesh-support #583)",
    r"(?<!\.)\.\./shared/(?!tools/run-with-vcan)",
    r"/work/|/tmp/w\b|/root/",
    r"\b(builder [A-Z]\b|(plan|style|design)\.md\b)",
    r"\b(CEO|LLM|chatbot|language model)\b",
    r"\bpypi\.org\b|\bpythonhosted\b|\bdeb\.debian\b",
)
# A session is Zenoh's connection, or the kernel's group of processes; nothing else is one.
SESSION = re.compile(r"(?<![.\w])sessions?\b", re.IGNORECASE)
ZENOH = re.compile(r"zenoh|core\.session|start_new_session", re.IGNORECASE)


def text_files() -> Iterator[Path]:
    for path in ROOT.rglob("*"):
        parts = path.relative_to(ROOT).parts
        hidden = any(part.startswith(".") and part != ".ci" for part in parts[:-1])
        if (
            not hidden
            and not NOT_OURS.intersection(parts)
            and path.is_file()
            and path.suffix in ENDINGS
        ):
            yield path


def test_finds_the_readme_and_the_launcher() -> None:
    names = {path.name for path in text_files()}
    assert {"README.md", "ulna", "check", "pyproject.toml", "robot.toml"} <= names


def test_speaks_of_nothing_else() -> None:
    found = []
    for path in text_files():
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            if any(re.search(pattern, line) for pattern in FORBIDDEN):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()}")
    assert "\n".join(found) == ""


def test_sessions_are_zenohs() -> None:
    found = []
    for path in text_files():
        text = path.read_text(encoding="utf-8").replace('scope="session"', "")  # pytest's word
        if SESSION.search(text) and not ZENOH.search(text):
            found.append(str(path.relative_to(ROOT)))
    assert found == []
