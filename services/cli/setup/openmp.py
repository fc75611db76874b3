"""Gives pinocchio an OpenMP runtime on a system that has none.

Its wheel expects the system's libgomp.so.1, which a bare Debian lacks (package libgomp1). CasADi's
wheel brings the same library under another name, so that is linked to where pinocchio looks.
"""

import ctypes
from pathlib import Path

LIBRARY = "libgomp.so.1"


def lend_openmp(venv: Path) -> None:
    """Link CasADi's libgomp beside pinocchio's libraries unless the system has its own."""
    try:
        ctypes.CDLL(LIBRARY)
    except OSError:
        pass
    else:
        return
    for site_packages in venv.glob("lib/python3*/site-packages"):
        link = site_packages / "cmeel.prefix" / "lib" / LIBRARY
        bundled = sorted(site_packages.glob("casadi/libgomp-*.so.*"))
        if bundled and link.parent.is_dir():
            link.unlink(missing_ok=True)
            link.symlink_to(bundled[-1])
