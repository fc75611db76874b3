"""`ulna can up`: make the virtual CAN interfaces that a robot's buses stand for."""

import os
import shutil
import subprocess
import sys

from hal.buses.socketcan import interfaces_up

INTERFACES = tuple(f"vcan{number}" for number in range(10))  # the iCub has ten buses


def can_up() -> int:
    """Make vcan0 to vcan9 and bring them up, or print the commands that need root.

    Returns:
        Exit status: 0 all are up, 1 somebody with the right to do it has to.
    """
    if interfaces_up(INTERFACES):
        print(f"up: {', '.join(INTERFACES)}")
        return 0
    commands = [command for name in INTERFACES for command in commands_for(name)]
    if os.geteuid() == 0 and shutil.which("ip") and all(_runs(command) for command in commands):
        print(f"made and up: {', '.join(INTERFACES)}")
        return 0
    print(
        "Needs root and a kernel with SocketCAN (modules can, can_raw and vcan). Run:",
        file=sys.stderr,
    )
    print("sudo modprobe vcan")
    for name in INTERFACES:
        print(f"sudo ip link add dev {name} type vcan; sudo ip link set {name} up")
    return 1


def commands_for(name: str) -> list[list[str]]:
    """What brings one interface up; made first where it is not there."""
    make = ["ip", "link", "add", "dev", name, "type", "vcan"]
    raise_up = ["ip", "link", "set", name, "up"]
    return [raise_up] if os.path.exists(f"/sys/class/net/{name}") else [make, raise_up]


def _runs(command: list[str]) -> bool:
    """Run a command; its own complaint is enough of a message."""
    return subprocess.run(command, check=False).returncode == 0
