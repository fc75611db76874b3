"""Which link hangs on which joint, read from a robot's URDF."""

import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path

from services.core.errors import ConfigError


class ModelTree:
    """The tree of one URDF. A link is also called by a fixed joint that ends in it."""

    def __init__(self, urdf: Path) -> None:
        self._urdf = urdf
        self._above: dict[str, tuple[str, str]] = {}  # link -> (joint it hangs on, parent link)
        self._child: dict[str, str] = {}  # joint -> link
        self._fixed: set[str] = set()
        links = []
        root = ElementTree.parse(urdf).getroot()
        for joint in root.findall("joint"):
            parent, child = joint.find("parent"), joint.find("child")
            if parent is None or child is None:
                continue
            name, link = str(joint.get("name")), str(child.get("link"))
            self._above[link] = (name, str(parent.get("link")))
            self._child[name] = link
            if joint.get("type") == "fixed":
                self._fixed.add(name)
            links.append(link)
        self.links = tuple(links)

    def link_of(self, frame: str) -> str:
        """The link that a frame is, or that a joint of that name ends in.

        Raises:
            ConfigError: the model has neither.
        """
        link = self._child.get(frame, frame)
        if link not in self._above and link not in {parent for _, parent in self._above.values()}:
            raise ConfigError(f"{self._urdf} has no link or frame {frame!r}")
        return link

    def joints_above(self, frame: str) -> tuple[str, ...]:
        """All joints from the frame to the root, fixed ones too, nearest first."""
        link = self.link_of(frame)
        joints = []
        while link in self._above:
            joint, link = self._above[link]
            joints.append(joint)
        return tuple(joints)

    def body_of(self, frame: str, cuts: frozenset[str]) -> str:
        """First link of the rigid body that a frame belongs to; `cuts` are fixed joints kept."""
        link = self.link_of(frame)
        while link in self._above:
            joint, parent = self._above[link]
            if joint not in self._fixed or joint in cuts:
                return link
            link = parent
        return link


@cache
def model_tree(urdf: Path) -> ModelTree:
    """The tree of a file, read once."""
    return ModelTree(urdf)
