"""What touches the robot: detection with hysteresis per assumed contact, and where it is.

The place comes from skin where a skin board knows its link, else from the wrench and the shapes of
the links beyond the sensor, else it is the assumed one. Where the wrench fits several links, or
none, the place is unsure.
"""

import math
from dataclasses import dataclass

import numpy as np

from dforc.arrays import Vector
from dforc.contacts.detection import ContactDetector
from dforc.contacts.location import Location, locate
from dforc.contacts.shapes import LinkShapes
from dforc.estimation.assumption import Assumption, Contact
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from services.body import Body
from services.dynamics_messages import ContactEstimate
from services.messages import Vector3

ON_N, OFF_N = 4.0, 2.5  # of a contact that no sensor stands above
LOCATE_EVERY = 5  # looks; a location costs as much as twenty estimates
SIGNIFICANT_N = 5.0  # weaker contacts are not located


@dataclass(slots=True, eq=False)
class _Watched:
    """One assumed contact and what is known of it."""

    contact: Contact
    limb: str
    link: str
    sensor: int  # the first above it; -1 where none is
    detector: ContactDetector
    shapes: LinkShapes | None  # of the links beyond that sensor
    since_ns: int = 0
    found: Location | None = None
    by_skin: str = ""


class ContactWatch:
    """Follows the contacts of one assumption; `look` once per filtered estimate."""

    def __init__(self, body: Body, shapes: LinkShapes | None) -> None:
        self._body = body
        self._shapes = shapes
        self._watched: list[_Watched] = []
        self._looks = 0

    def assume(self, assumption: Assumption) -> None:
        """Start anew with other contacts, all untouched."""
        self._watched = [self._watch(contact) for contact in assumption.contacts]

    def is_touched(self, sensor: int) -> bool:
        """Whether something touches the limb between a sensor and the next ones."""
        return any(w.detector.touching for w in self._watched if w.sensor == sensor)

    def of_sensor(self, sensor: int) -> tuple[int, ...]:
        """Which contacts of the assumption a sensor feels first."""
        return tuple(i for i, w in enumerate(self._watched) if w.sensor == sensor)

    def is_touched_beyond(self, sensor: int) -> bool:
        """Whether something touches anything beyond a sensor."""
        frame = self._body.sensors[sensor].frame
        return any(
            w.detector.touching and frame in self._body.tree.joints_above(w.contact.frame)
            for w in self._watched
        )

    def assumed(self, assumption: Assumption) -> tuple[Contact, ...]:
        """The contacts of an assumption, those that are located for sure at their links."""
        return tuple(
            self._moved(watched) or contact
            for watched, contact in zip(self._watched, assumption.contacts, strict=True)
        )

    def look(
        self,
        now_ns: int,
        estimate: BodyEstimate,
        estimator: WholeBodyEstimator,
        usable: tuple[bool, ...],
    ) -> tuple[ContactEstimate, ...]:
        """Judge one filtered estimate; `usable` says which sensors it stands on."""
        self._looks += 1
        wrenches, points = estimate.contact_wrenches, estimate.contact_points_m
        return tuple(
            self._judge(now_ns, watched, wrenches[i], points[i], estimator, usable)
            for i, watched in enumerate(self._watched)
        )

    def _judge(
        self,
        now_ns: int,
        watched: _Watched,
        wrench: Vector,
        point: Vector,
        estimator: WholeBodyEstimator,
        usable: tuple[bool, ...],
    ) -> ContactEstimate:
        was_touching = watched.detector.touching
        felt = watched.sensor < 0 or usable[watched.sensor]
        force_n = math.hypot(*wrench[:3].tolist())
        if felt:
            watched.detector.update(force_n)
        else:
            watched.detector.reset()
        touching = watched.detector.touching
        if touching != was_touching:
            watched.since_ns = now_ns
            watched.found = None
        if touching and (self._looks % LOCATE_EVERY == 0 or watched.found is None):
            self._locate(watched, wrench, point, estimator)
        return self._estimate(watched, wrench, point)

    def _locate(
        self, watched: _Watched, wrench: Vector, point: Vector, estimator: WholeBodyEstimator
    ) -> None:
        """Look for the link; a place that is sure holds until the contact ends or moves."""
        if watched.shapes is None or watched.sensor < 0 or watched.contact.kind != "wrench":
            return
        if float(np.linalg.norm(wrench[:3])) < SIGNIFICANT_N:
            return
        _, origin = estimator.frame_pose(self._body.sensors[watched.sensor].frame)
        moment = wrench[3:] + np.cross(point - origin, wrench[:3])
        posed = watched.shapes.posed_by(estimator.frame_pose)
        watched.found = locate(wrench[:3], moment, origin, posed)

    def _estimate(self, watched: _Watched, wrench: Vector, point: Vector) -> ContactEstimate:
        location, link = "assumed", watched.link
        moment = wrench[3:]
        found = watched.found
        if watched.by_skin:
            location, link = "skin", watched.by_skin
        elif found is not None and found.certainty == "sure":
            location, link = "shape", found.link
            moment = moment + np.cross(point - found.point_m, wrench[:3])
            point = found.point_m
        elif found is not None:
            location = "unsure"
        return ContactEstimate(
            limb=watched.limb,
            link=link,
            point_m=_vector3(point),
            force_n=_vector3(wrench[:3]),
            moment_nm=_vector3(moment),
            touching=watched.detector.touching,
            location=location,
            sensor=self._body.sensors[watched.sensor].name if watched.sensor >= 0 else "",
            since_ns=watched.since_ns,
        )

    def _watch(self, contact: Contact) -> _Watched:
        body = self._body
        above = body.tree.joints_above(contact.frame)
        frames = {sensor.frame: i for i, sensor in enumerate(body.sensors)}
        sensor = next((frames[joint] for joint in above if joint in frames), -1)
        on_n, off_n = ON_N, OFF_N
        if sensor >= 0:
            on_n, off_n = body.sensors[sensor].contact_on_n, body.sensors[sensor].contact_off_n
        return _Watched(
            contact=contact,
            limb=self._limb(above),
            link=body.tree.link_of(contact.frame),
            sensor=sensor,
            detector=ContactDetector(on_n, off_n),
            shapes=self._shapes_beyond(sensor, frames),
        )

    def _limb(self, above: tuple[str, ...]) -> str:
        of_joint = {joint: part.name for part in self._body.parts for joint in part.joints}
        return next((of_joint[joint] for joint in above if joint in of_joint), "")

    def _shapes_beyond(self, sensor: int, frames: dict[str, int]) -> LinkShapes | None:
        if self._shapes is None or sensor < 0:
            return None
        links = [
            link
            for link in self._shapes.links
            if next((frames[a] for a in self._body.tree.joints_above(link) if a in frames), -1)
            == sensor
        ]
        return self._shapes.only(links) if links else None

    def _moved(self, watched: _Watched) -> Contact | None:
        """The contact at the link where it is for sure, if that is not where it is assumed."""
        found = watched.found
        link = watched.by_skin or (found.link if found and found.certainty == "sure" else "")
        if not link or link == watched.link:
            return None
        return Contact(frame=link)


def _vector3(values: Vector) -> Vector3:
    x, y, z = values.tolist()
    return (x, y, z)
