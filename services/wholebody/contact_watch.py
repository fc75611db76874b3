"""What touches the robot: detection with hysteresis per assumed contact, and where it is.

The place comes from skin where a skin board knows its link, else from the wrench and the shapes of
the links beyond the sensor, else it is the assumed one. Where the wrench fits several links, or
none, the place is unsure. A learner that knows how little it leaves lowers the threshold, as far
as the robot file allows. The torques follow touch and place as readings and model alone have them:
a wrong learner moves nothing.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dforc.arrays import Vector
from dforc.contacts.detection import ContactDetector
from dforc.contacts.location import Location, WrenchNoise, locate
from dforc.contacts.shapes import LinkShapes
from dforc.contacts.skin import SkinContact
from dforc.estimation.assumption import Assumption, Contact
from dforc.estimation.estimate import BodyEstimate
from dforc.estimation.estimator import WholeBodyEstimator
from services.messages import Vector3
from services.wholebody.body import Body
from services.wholebody.dynamics_messages import ContactEstimate
from services.wholebody.skin_watch import SkinWatch

ON_N, OFF_N = 4.0, 2.5  # of a contact that no sensor stands above
LEARNED_SPREADS = 4.0  # of what a learner leaves: on a recorded arm 1 sample in 1000 has 3.5
LOCATE_EVERY = 5  # looks; a location costs as much as twenty estimates
SIGNIFICANT_N = 5.0  # weaker contacts are not located


class Evidence(NamedTuple):
    """One filtered estimate and what it stands on."""

    estimate: BodyEstimate
    uncorrected: BodyEstimate  # without the learner; the same object where none corrects
    usable: tuple[bool, ...]  # sensors
    spread_n: Sequence[float]  # per sensor, of the force that the learner leaves; inf = none does
    noise: Callable[[int], WrenchNoise]  # of a sensor untouched, beside model and learner
    model_noise: Callable[[int], WrenchNoise]  # the same beside the model alone


@dataclass(slots=True, eq=False)
class _Watched:
    """One assumed contact and what is known of it."""

    contact: Contact
    limb: str
    link: str
    sensor: int  # the first above it; -1 where none is
    detector: ContactDetector
    model_detector: ContactDetector  # of what the model alone does not explain
    on_n: float  # of both
    learned_on_n: float  # at best
    shapes: LinkShapes | None  # of the links beyond that sensor
    since_ns: int = 0
    touching: bool = False  # by force or by skin
    found: Location | None = None
    model_found: Location | None = None  # without the learner, for the torques
    skin: SkinContact | None = None


class ContactWatch:
    """Follows the contacts of one assumption; `look` once per filtered estimate."""

    def __init__(self, body: Body, shapes: LinkShapes, skin: SkinWatch) -> None:
        self._body = body
        self._shapes = shapes
        self._skin = skin
        self._watched: list[_Watched] = []
        self._looks = 0

    def assume(self, assumption: Assumption) -> None:
        """Start anew with other contacts, all untouched."""
        self._watched = [self._watch(contact) for contact in assumption.contacts]

    def is_touched(self, sensor: int) -> bool:
        """Whether something touches the limb between a sensor and the next ones."""
        return any(w.touching for w in self._watched if w.sensor == sensor)

    def of_sensor(self, sensor: int) -> tuple[int, ...]:
        """Which contacts of the assumption a sensor feels first."""
        return tuple(i for i, w in enumerate(self._watched) if w.sensor == sensor)

    def is_touched_beyond(self, sensor: int) -> bool:
        """Whether something touches anything beyond a sensor."""
        frame = self._body.sensors[sensor].frame
        return any(
            w.touching and frame in self._body.tree.joints_above(w.contact.frame)
            for w in self._watched
        )

    def assumed(self, assumption: Assumption) -> tuple[Contact, ...]:
        """The contacts of an assumption, those that are located for sure at their links."""
        return tuple(
            self._moved(watched) or contact
            for watched, contact in zip(self._watched, assumption.contacts, strict=True)
        )

    def look(
        self, now_ns: int, evidence: Evidence, estimator: WholeBodyEstimator
    ) -> tuple[ContactEstimate, ...]:
        """Judge one filtered estimate, which was the estimator's last one."""
        self._looks += 1
        return tuple(
            self._judge(now_ns, watched, i, evidence, estimator)
            for i, watched in enumerate(self._watched)
        )

    def _judge(
        self,
        now_ns: int,
        watched: _Watched,
        row: int,
        evidence: Evidence,
        estimator: WholeBodyEstimator,
    ) -> ContactEstimate:
        sensor, estimate = watched.sensor, evidence.estimate
        wrench, point = estimate.contact_wrenches[row], estimate.contact_points_m[row]
        model_wrench = evidence.uncorrected.contact_wrenches[row]
        if sensor < 0 or evidence.usable[sensor]:
            spread_n = evidence.spread_n[sensor] if sensor >= 0 else math.inf
            on_n = max(watched.learned_on_n, LEARNED_SPREADS * spread_n)
            watched.detector.update(_force_n(wrench) * max(watched.on_n / on_n, 1.0))
            watched.model_detector.update(_force_n(model_wrench))
        else:
            watched.detector.reset()
            watched.model_detector.reset()
        watched.skin = self._skin.pressed(sensor)
        touching = watched.detector.touching or watched.skin is not None
        if touching != watched.touching:
            watched.touching = touching
            watched.since_ns = now_ns
            watched.found = None
        if not watched.model_detector.touching:
            watched.model_found = None
        elif self._is_due(watched.model_found):
            noise = evidence.model_noise(sensor)
            before = watched.model_found
            watched.model_found = self._located(
                watched, before, model_wrench, point, noise, estimator
            )
        if watched.detector.touching:
            if evidence.uncorrected is estimate:
                watched.found = watched.model_found
            elif self._is_due(watched.found):
                noise = evidence.noise(sensor)
                watched.found = self._located(
                    watched, watched.found, wrench, point, noise, estimator
                )
        return self._estimate(watched, wrench, point, estimator)

    def _is_due(self, found: Location | None) -> bool:
        return found is None or self._looks % LOCATE_EVERY == 0

    def _located(
        self,
        watched: _Watched,
        before: Location | None,
        wrench: Vector,
        point: Vector,
        noise: WrenchNoise,
        estimator: WholeBodyEstimator,
    ) -> Location | None:
        """Look for the link; a place that is sure holds until the contact ends or moves."""
        if watched.shapes is None or watched.contact.kind != "wrench":
            return before
        if _force_n(wrench) < SIGNIFICANT_N:
            return before
        _, origin = estimator.frame_pose(self._body.sensors[watched.sensor].frame)
        moment = wrench[3:] + np.cross(point - origin, wrench[:3])
        posed = watched.shapes.posed_by(estimator.frame_pose)
        found = locate(wrench[:3], moment, origin, posed, noise)
        keeps = before is not None and _is_sure(before) and not _is_sure(found)
        return before if keeps else found

    def _estimate(
        self, watched: _Watched, wrench: Vector, point: Vector, estimator: WholeBodyEstimator
    ) -> ContactEstimate:
        location, link, place = "assumed", watched.link, point
        found = watched.found
        if watched.skin is not None:
            turn, origin = estimator.frame_pose(watched.skin.link)
            location, link = "skin", watched.skin.link
            place = origin + turn @ np.array(watched.skin.point_m)
        elif found is not None and _is_sure(found):
            location, link, place = "shape", found.link, found.point_m
        elif found is not None:
            location = "unsure"
        moment = wrench[3:]
        if place is not point:
            moment = moment + np.cross(point - place, wrench[:3])
        return ContactEstimate(
            limb=watched.limb,
            link=link,
            point_m=_vector3(place),
            force_n=_vector3(wrench[:3]),
            moment_nm=_vector3(moment),
            touching=watched.touching,
            location=location,
            sensor=self._body.sensors[watched.sensor].name if watched.sensor >= 0 else "",
            since_ns=watched.since_ns,
        )

    def _watch(self, contact: Contact) -> _Watched:
        body = self._body
        above = body.tree.joints_above(contact.frame)
        frames = {sensor.frame: i for i, sensor in enumerate(body.sensors)}
        sensor = next((frames[joint] for joint in above if joint in frames), -1)
        on_n, off_n, learned_on_n = ON_N, OFF_N, ON_N
        if sensor >= 0:
            table = body.sensors[sensor]
            on_n, off_n = table.contact_on_n, table.contact_off_n
            learned_on_n = table.contact_learned_on_n
        return _Watched(
            contact=contact,
            limb=self._limb(above),
            link=body.tree.link_of(contact.frame),
            sensor=sensor,
            detector=ContactDetector(on_n, off_n),
            model_detector=ContactDetector(on_n, off_n),
            on_n=on_n,
            learned_on_n=learned_on_n,
            shapes=self._shapes_beyond(sensor, frames),
        )

    def _limb(self, above: tuple[str, ...]) -> str:
        of_joint = {joint: part.name for part in self._body.parts for joint in part.joints}
        return next((of_joint[joint] for joint in above if joint in of_joint), "")

    def _shapes_beyond(self, sensor: int, frames: dict[str, int]) -> LinkShapes | None:
        if sensor < 0:
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
        link = ""
        if watched.skin is not None:
            link = watched.skin.link
        elif watched.model_found is not None and _is_sure(watched.model_found):
            link = watched.model_found.link
        moved = watched.contact.kind == "wrench" and link not in ("", watched.link)
        return Contact(frame=link) if moved else None


def _force_n(wrench: Vector) -> float:
    return math.hypot(*wrench[:3].tolist())


def _is_sure(found: Location) -> bool:
    return found.certainty == "sure"


def _vector3(values: Vector) -> Vector3:
    x, y, z = values.tolist()
    return (x, y, z)
