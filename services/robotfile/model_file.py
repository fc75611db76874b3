"""The file of a robot's rigid-body model, with the sensor frames that the robot file adds to it."""

import math
import xml.etree.ElementTree as ElementTree
from functools import cache
from hashlib import sha256
from os import getpid, getuid
from pathlib import Path
from tempfile import gettempdir

from services.core.errors import ConfigError
from services.robotfile.robot_tables import RobotFile


@cache
def urdf_path(urdf: str) -> Path:
    """File of an icub-models robot, or of a path that ends in .urdf.

    Raises:
        ConfigError: there is no such model; the known ones are listed.
    """
    if urdf.endswith(".urdf"):
        return Path(urdf)
    import icub_models

    path = Path(str(icub_models.get_model_file(urdf)))
    if not path.is_file():
        known = ", ".join(sorted(icub_models.get_robot_names()))
        raise ConfigError(f"robot.urdf: no model {urdf!r} in icub-models; known: {known}")
    return path


@cache
def model_limits_deg(urdf: Path) -> dict[str, tuple[float, float]]:
    """Position limits of every revolute joint of a URDF."""
    limits = {}
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):
        limit = joint.find("limit")
        if joint.get("type") == "revolute" and limit is not None:
            low, high = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
            limits[str(joint.get("name"))] = (math.degrees(low), math.degrees(high))
    return limits


def model_path(robot: RobotFile) -> Path:
    """File of the robot's model, with the frames of those sensors that the model has not got.

    A sensor `behind` a joint sits where the joint's link begins: that link is cut in two there.
    """
    plain = urdf_path(robot.robot.urdf)
    added = tuple((name.frame, name.behind) for name in robot.sensors.values() if name.behind)
    return with_frames(plain, added) if added else plain


@cache
def with_frames(urdf: Path, added: tuple[tuple[str, str], ...]) -> Path:
    """A copy of a URDF with fixed joints put behind joints: (name of the new one, joint).

    Raises:
        ConfigError: the model has no such joint.
    """
    tree = ElementTree.parse(urdf)
    root = tree.getroot()
    joints = {joint.get("name"): joint for joint in root.iter("joint")}
    for frame, behind in added:
        joint = joints.get(behind)
        child = None if joint is None else joint.find("child")
        if child is None:
            raise ConfigError(f"sensor frame {frame}: {urdf} has no joint {behind!r}")
        near = f"{frame}_near_side"
        ElementTree.SubElement(root, "link", name=near)
        fixed = ElementTree.SubElement(root, "joint", name=frame, type="fixed")
        ElementTree.SubElement(fixed, "origin", xyz="0 0 0", rpy="0 0 0")
        ElementTree.SubElement(fixed, "parent", link=near)
        ElementTree.SubElement(fixed, "child", link=str(child.get("link")))
        child.set("link", near)
    text = ElementTree.tostring(root, encoding="unicode")
    folder = Path(gettempdir()) / f"ulna-{getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    path = folder / f"{urdf.stem}-{sha256(text.encode()).hexdigest()[:16]}.urdf"
    if not path.is_file():
        fresh = path.with_suffix(f".{getpid()}")
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(path)  # others read it at the same time
    return path
