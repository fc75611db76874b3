"""Reads what pip prints: progress, the bytes for the summary, and the reason when it fails.

Standard library only: ./ulna runs this before anything is installed.
"""

import re
from collections import deque
from collections.abc import Callable
from pathlib import Path

from services.core.clock import NS_PER_S, wall_ns

FETCHED = re.compile(r"^\s*(Downloading|Using cached) (\S+\.whl) \(([\d.]+) (bytes|kB|MB|GB)\)")
LOCAL = re.compile(r"^\s*Processing (/\S+\.whl)")  # a local index or find-links folder
MB = {"bytes": 1e-6, "kB": 1e-3, "MB": 1.0, "GB": 1e3}
NAMED_FROM_MB = 5.0  # smaller packages pass without a line
TAIL_LINES = 40

# What pip says -> what the user needs to know. The first match counts.
REASONS = (
    (r"No space left on device", "the disk is full: .venv takes about 1.5 GB"),
    (
        r"DO NOT MATCH THE HASHES",
        "a downloaded file is not the one that the lock names; nothing of it was installed",
    ),
    (
        r"CERTIFICATE_VERIFY_FAILED|SSLError|TLS CA certificate bundle",
        "the package index's certificate is not trusted; set PIP_CERT to your network's CA file",
    ),
    (
        r"NewConnectionError|NameResolutionError|name resolution|Name or service not known"
        r"|Max retries|Network is unreachable|Connection refused|Connection reset|timed out"
        r"|ConnectTimeout|ReadTimeout|ProxyError|Temporary failure",
        "the package index cannot be reached; set-up needs the network once"
        " (behind a proxy set https_proxy, with a mirror PIP_INDEX_URL)",
    ),
    (
        r"No matching distribution found for (\S+)",
        "no ready-made package of {0} for this machine and Python",
    ),
)


class PipOutput:
    """Follows one run of `pip install`, line by line."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._start_ns = wall_ns()
        self._fetched_ns = self._start_ns
        self._downloaded_mb = 0.0
        self._here_mb = 0.0
        self._lines: deque[str] = deque(maxlen=TAIL_LINES)

    def feed(self, line: str) -> None:
        """Take one line of pip's output."""
        self._lines.append(line)
        if match := FETCHED.match(line):
            how, file, number, unit = match.groups()
            self._count(file, float(number) * MB[unit], here=how == "Using cached")
        elif match := LOCAL.match(line):
            path = Path(match[1])
            self._count(path.name, path.stat().st_size * MB["bytes"], here=True)
        elif line.startswith("Installing collected packages"):
            self._fetched_ns = wall_ns()
            self._say(f"unpacking {line.count(',') + 1} packages")

    def _count(self, file: str, size_mb: float, *, here: bool) -> None:
        if here:
            self._here_mb += size_mb
        else:
            self._downloaded_mb += size_mb
        if size_mb >= NAMED_FROM_MB:
            name, version = file.split("-")[:2]
            source = " (already on this machine)" if here else ""
            self._say(f"  {name} {version}, {size_mb:.0f} MB{source}")

    @property
    def tail(self) -> str:
        """The last lines, for an explanation."""
        return "".join(self._lines)

    def summary(self) -> str:
        """Bytes and seconds, as the last line of the set-up tells them."""
        seconds = (self._fetched_ns - self._start_ns) / NS_PER_S
        text = f"{self._downloaded_mb:.0f} MB downloaded in {seconds:.0f} s"
        here_mb = self._here_mb
        return f"{text}, {here_mb:.0f} MB already on this machine" if here_mb >= 1.0 else text


def explain(output: str, log_path: Path) -> str:
    """One sentence that says why pip failed and what to do."""
    for pattern, reason in REASONS:
        if match := re.search(pattern, output):
            return f"{reason.format(*match.groups())} (pip's words: {log_path})"
    return f"pip failed; its words are in {log_path}"
