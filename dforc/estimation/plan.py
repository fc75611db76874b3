"""What one assumption and one set of valid sensors make of a model: sub-models and flat tables.

The valid sensors cut the tree into sub-models: number 0 holds the base, number g > 0 what lies
beyond the g-th valid sensor up to the next ones. A sensor that is not valid cuts nothing, so its
sub-model is one with its neighbour's. Everything that does not change from tick to tick is worked
out here, once, in the form that both paths read.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dforc.arrays import Matrix, Vector
from dforc.estimation.assumption import UNKNOWNS, Assumption, AssumptionError, Contact, KnownWrench
from dforc.estimation.tree_model import Indices, TreeModel

GRAVITY_M_S2 = 9.81
LEVER_M = 0.1  # a moment of 0.1 Nm weighs as much as a force of 1 N, in norms and in residuals
RANK_TOLERANCE = 1e-4  # of the largest singular value; what is below counts as not measurable

# How the unknowns of a sub-model are found.
NOTHING, MAINSTAY, WRENCH, FORCE, DIRECTION, SEVERAL = range(6)
SUB_MODEL_NUMBERS = 7  # residual (6), rank


class PlacedContact(NamedTuple):
    """A contact in the axes of its body."""

    body: int
    sub_model: int
    unknowns: int  # 6, 3, 1; or 0 where the contact does not count
    point: Vector
    direction: Vector


class PlacedWrench(NamedTuple):
    """A known wrench in the axes of its body, about the body's origin."""

    body: int
    sub_model: int
    wrench: Vector


class Layout:
    """Where each result stands in the flat vector of one estimate."""

    def __init__(self, bodies: int, joints: int, sensors: int, contacts: int) -> None:
        self.bodies, self.joints, self.sensors, self.contacts = bodies, joints, sensors, contacts
        sizes = (
            12 * bodies,
            joints,
            6 * contacts,
            3 * contacts,
            6,
            6 * sensors,
            SUB_MODEL_NUMBERS * (sensors + 1),
        )
        ends = [sum(sizes[: i + 1]) for i in range(len(sizes))]
        self.starts = (0, *ends[:-1])
        self.poses, self.tau, self.wrenches, self.points, self.base, self.internal, self.subs = (
            slice(start, end) for start, end in zip(self.starts, ends, strict=True)
        )
        self.size = ends[-1]


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Everything of one (assumption, mask) that stays."""

    model: TreeModel
    assumption: Assumption
    layout: Layout
    valid: tuple[bool, ...]
    sub_model_of_body: tuple[int, ...]
    tops: tuple[int, ...]  # sensor at the top of each sub-model, -1 for the first
    methods: tuple[int, ...]  # how each sub-model is solved
    contacts: tuple[PlacedContact, ...]
    known: tuple[PlacedWrench, ...]
    source_body: int  # -1: the base stands still
    source_turn: Matrix
    source_point: Vector

    def members(self, sub_model: int) -> tuple[int, ...]:
        """Which contacts count in a sub-model."""
        return tuple(
            i for i, c in enumerate(self.contacts) if c.sub_model == sub_model and c.unknowns
        )

    def unknowns(self, sub_model: int) -> int:
        """How many numbers are sought in a sub-model."""
        held = 6 if self.methods[sub_model] == MAINSTAY else 0
        return held + sum(self.contacts[i].unknowns for i in self.members(sub_model))

    def links(self, sub_model: int) -> tuple[str, ...]:
        """Names of the links in a sub-model."""
        return tuple(
            link
            for link in self.model.links
            if self.sub_model_of_body[self.model.body_of(link)] == sub_model
        )

    def sensors(self, sub_model: int) -> tuple[str, ...]:
        """Names of the valid sensors around a sub-model, the one towards the base first."""
        around = [self.tops[sub_model]] if sub_model else []
        subs = range(1, len(self.tops))
        around += [self.tops[sub] for sub in subs if self.above(sub) == sub_model]
        return tuple(self.model.sensors[sensor] for sensor in around)

    def above(self, sub_model: int) -> int:
        """The sub-model on the near side of the sensor at the top of this one."""
        body = self.model.sensor_body[self.tops[sub_model]]
        return self.sub_model_of_body[int(self.model.parent[body])]


def make_plan(model: TreeModel, assumption: Assumption, valid: Sequence[bool]) -> Plan:
    """Cut the model at its valid sensors and place what is assumed.

    Raises:
        AssumptionError: a frame is unknown.
    """
    tops = (-1, *(sensor for sensor in range(model.m) if valid[sensor]))
    sub_model_of_body = _sub_models(model, tops)
    contacts = _placed(model, assumption, sub_model_of_body)
    known = tuple(_known(model, wrench, sub_model_of_body) for wrench in assumption.known)
    methods = tuple(_method(assumption, contacts, sub) for sub in range(len(tops)))
    source = assumption.source
    if source and not model.has_frame(source):
        raise AssumptionError(f"kinematic source: the model has no frame {source!r}")
    place = model.frame(source if source else model.links[0])
    return Plan(
        model=model,
        assumption=assumption,
        layout=Layout(model.bodies, model.n, model.m, len(contacts)),
        valid=tuple(bool(v) for v in valid),
        sub_model_of_body=sub_model_of_body,
        tops=tops,
        methods=methods,
        contacts=contacts,
        known=known,
        source_body=place.body if source else -1,
        source_turn=place.R,
        source_point=place.p,
    )


def _sub_models(model: TreeModel, tops: tuple[int, ...]) -> tuple[int, ...]:
    """The sub-model of every body."""
    first = {model.sensor_body[sensor]: sub for sub, sensor in enumerate(tops) if sensor >= 0}
    found: Indices = np.zeros(model.bodies, dtype=np.int64)
    for body in range(1, model.bodies):
        found[body] = first.get(body, int(found[model.parent[body]]))
    return tuple(found.tolist())


def _placed(
    model: TreeModel, assumption: Assumption, sub_model_of_body: tuple[int, ...]
) -> tuple[PlacedContact, ...]:
    """The contacts on their bodies; those that do not count have no unknowns."""
    subs = [sub_model_of_body[_body(model, contact)] for contact in assumption.contacts]
    taken = {sub for sub, c in zip(subs, assumption.contacts, strict=True) if not c.fallback}
    if assumption.mainstay:
        taken.add(0)
    placed = []
    for sub, contact in zip(subs, assumption.contacts, strict=True):
        counts = not contact.fallback or sub not in taken
        if contact.fallback:
            taken.add(sub)
        place = model.frame(contact.frame)
        point = place.p + place.R @ np.array(contact.point_m)
        direction = place.R @ np.array(contact.direction or (0.0, 0.0, 0.0))
        unknowns = UNKNOWNS[contact.kind] if counts else 0
        placed.append(PlacedContact(place.body, sub, unknowns, point, direction))
    return tuple(placed)


def _body(model: TreeModel, given: Contact | KnownWrench) -> int:
    if not model.has_frame(given.frame):
        raise AssumptionError(f"the model has no link or frame {given.frame!r} to be touched")
    return model.frame(given.frame).body


def _known(
    model: TreeModel, given: KnownWrench, sub_model_of_body: tuple[int, ...]
) -> PlacedWrench:
    body = _body(model, given)
    _, R, p = model.frame(given.frame)
    point = p + R @ np.array(given.point_m)
    force, moment = R @ np.array(given.wrench[:3]), R @ np.array(given.wrench[3:])
    wrench = np.concatenate([force, moment + np.cross(point, force)])
    return PlacedWrench(body, sub_model_of_body[body], wrench)


def _method(assumption: Assumption, contacts: Sequence[PlacedContact], sub_model: int) -> int:
    """How a sub-model is solved. The mainstay takes all that it can, which is everything."""
    if sub_model == 0 and assumption.mainstay:
        return MAINSTAY
    unknowns = [c.unknowns for c in contacts if c.sub_model == sub_model and c.unknowns]
    if len(unknowns) > 1:
        return SEVERAL
    return {0: NOTHING, 6: WRENCH, 3: FORCE, 1: DIRECTION}[sum(unknowns)]
