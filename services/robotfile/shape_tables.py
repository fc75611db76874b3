"""The file shapes.toml beside a robot file: capsules of its links and places of its skin boards.

    urdf = "<model>"        the model that the shapes were made for
    [[shapes]]              link, start_m, end_m, radius_m: a capsule in the link's frame
    [[skin]]                board, link, point_m, assumed, and triangles_m where they are known

A robot without such a file, or with another model, gets one capsule from each joint to the next.
"""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import msgspec

from dforc.contacts.shapes import LinkCapsule, LinkShapes, Point, capsules_between_joints
from dforc.contacts.skin import TRIANGLES, SkinPatch
from dforc.errors import DforcError
from services.core.errors import ConfigError
from services.robotfile.model_file import urdf_path
from services.robotfile.robot_tables import RobotFile, Strict

FILE = "shapes.toml"
DEFAULT_RADIUS_M = 0.04  # an arm of the iCub is 3 to 4 cm thick about its middle

LEAST_MASS_KG = 0.001  # frames of a URDF weigh nothing, or next to nothing


class ShapeTable(Strict, frozen=True, kw_only=True):
    """[[shapes]]: one capsule."""

    link: str
    start_m: Point
    end_m: Point
    radius_m: float


class SkinTable(Strict, frozen=True, kw_only=True):
    """[[skin]]: the place of one board of the robot file."""

    board: str
    link: str
    point_m: Point
    assumed: bool  # nobody has measured it
    triangles_m: tuple[Point, ...] = ()


class ShapeFile(Strict, frozen=True, kw_only=True):
    """The whole file."""

    urdf: str
    shapes: tuple[ShapeTable, ...]
    skin: tuple[SkinTable, ...] = ()


def link_shapes(robot: RobotFile) -> LinkShapes:
    """Capsules of the robot's links.

    Raises:
        ConfigError: the file is wrong.
    """
    file = read_shape_file(robot)
    if file is None:
        children = child_origins(urdf_path(robot.robot.urdf))
        return LinkShapes(capsules_between_joints(children, DEFAULT_RADIUS_M))
    return _shapes(file, robot.path.with_name(FILE))


def skin_patches(robot: RobotFile) -> tuple[SkinPatch, ...]:
    """Places of the robot's skin boards; none without a file.

    Raises:
        ConfigError: the file is wrong.
    """
    file = read_shape_file(robot)
    if file is None:
        return ()
    return tuple(
        SkinPatch(
            board=row.board,
            limb=robot.boards[row.board].part,
            link=row.link,
            point_m=row.point_m,
            triangles_m=row.triangles_m,
        )
        for row in file.skin
        if row.board in robot.boards  # a selection of the robot's parts has fewer
    )


def read_shape_file(robot: RobotFile) -> ShapeFile | None:
    """The file beside the robot file; None without one for the robot's model.

    Raises:
        ConfigError: it is no TOML, has an unknown or missing key, a shape no capsule can have, or a
            link that the model has not got.
    """
    path = robot.path.with_name(FILE)
    if not path.is_file():
        return None
    try:
        file = msgspec.toml.decode(path.read_bytes(), type=ShapeFile)
    except msgspec.DecodeError as error:  # a ValidationError is one, too
        raise ConfigError(f"{path}: {error}") from error
    if file.urdf != robot.robot.urdf:
        return None
    _check(file, path)
    return file


def child_origins(urdf: Path) -> dict[str, list[Point]]:
    """For each link with a mass, where in its frame its child joints are."""
    root = ElementTree.parse(urdf).getroot()
    massive = [link for link in root.iter("link") if _mass_kg(link) > LEAST_MASS_KG]
    origins: dict[str, list[Point]] = {str(link.get("name")): [] for link in massive}
    for joint in root.iter("joint"):
        parent, origin = joint.find("parent"), joint.find("origin")
        name = "" if parent is None else str(parent.get("link"))
        if name in origins:
            text = "0 0 0" if origin is None else str(origin.get("xyz", "0 0 0"))
            x, y, z = (float(word) for word in text.split())
            origins[name].append((x, y, z))
    return origins


def _mass_kg(link: ElementTree.Element) -> float:
    mass = link.find("inertial/mass")
    return 0.0 if mass is None else float(mass.get("value", "0"))


def _check(file: ShapeFile, path: Path) -> None:
    root = ElementTree.parse(urdf_path(file.urdf)).getroot()
    links = {link.get("name") for link in root.iter("link")}
    named = [row.link for row in file.shapes] + [row.link for row in file.skin]
    unknown = [link for link in named if link not in links]
    if unknown:
        raise ConfigError(f"{path}: the model {file.urdf} has no link {unknown[0]!r}")
    for row in file.skin:
        if row.triangles_m and len(row.triangles_m) != TRIANGLES:
            raise ConfigError(
                f"{path}: skin.{row.board}.triangles_m has {len(row.triangles_m)} points, "
                f"not {TRIANGLES}"
            )
    _shapes(file, path)


def _shapes(file: ShapeFile, path: Path) -> LinkShapes:
    capsules = [
        LinkCapsule(link=row.link, start_m=row.start_m, end_m=row.end_m, radius_m=row.radius_m)
        for row in file.shapes
    ]
    try:
        return LinkShapes(capsules)
    except DforcError as error:
        raise ConfigError(f"{path}: shapes: {error}") from error
