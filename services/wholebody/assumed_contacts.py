"""Where the world is assumed to touch the robot: the named sets, and those of a request.

default    held at the base; beyond each FT sensor one contact, where the robot file says
standing   the paper's first set: held at the base, touched at hands and feet
crawling   the paper's second set: not held, carried by wrists and knees, moving with the IMU
custom     what the request lists; without a contact only where loads are known
"""

from dataclasses import replace

from dforc.errors import DforcError
from dforc.estimation.assumption import (
    Assumption,
    Contact,
    Kind,
    KnownWrench,
    crawling,
    standing,
)
from services.core.errors import ServiceError
from services.wholebody.body import Body
from services.wholebody.dynamics_messages import AssumedContact, DynamicsRequest, KnownLoad

BASE = "base"  # the kinematic source of a robot whose base stands still
SETS = ("default", "standing", "crawling", "custom")
KINDS: tuple[Kind, ...] = ("wrench", "force", "direction")


class AssumptionRefusedError(ServiceError):
    """A request asks for contacts or a source that this robot has not got."""


def default_assumption(body: Body) -> Assumption:
    """One contact beyond each sensor; the far ends of the limbs come first."""
    ordered = sorted(body.sensors, key=lambda s: -len(body.tree.joints_above(s.frame)))
    return Assumption(contacts=tuple(Contact(frame=s.contact_frame) for s in ordered))


def requested_assumption(body: Body, request: DynamicsRequest, source: str) -> Assumption:
    """What a request of action `assume` means; `source` is the frame in force.

    Raises:
        AssumptionRefusedError: no such set, frame or kind, no contact at all, a load that is not
            finite, crawling without an IMU, or frames for a set that takes none.
    """
    if request.value in SETS and request.value != "custom":
        listed = [contact.frame for contact in request.contacts]
        listed += [] if request.mainstay or request.value == "crawling" else ["a base that hangs"]
        if listed:
            text = ", ".join(listed)
            raise AssumptionRefusedError(f"{request.value} does not take {text}; `custom` does")
    known = tuple(_known(body, load) for load in request.known)
    return replace(_named_set(body, request, source), known=known)


def _named_set(body: Body, request: DynamicsRequest, source: str) -> Assumption:
    if request.value == "default":
        return replace(default_assumption(body), source=source)
    if request.value == "standing":
        return replace(_of_these_limbs(body, standing()), source=source)
    if request.value == "crawling":
        if not body.imus:
            raise AssumptionRefusedError("crawling needs an IMU, and the parts in use have none")
        return _of_these_limbs(body, crawling(source=next(iter(body.imus.values()))))
    if request.value == "custom":
        if not request.contacts and not request.known:
            raise AssumptionRefusedError("custom needs a contact, or a known load; none is named")
        contacts = tuple(_contact(body, contact) for contact in request.contacts)
        return Assumption(contacts=contacts, source=source, mainstay=request.mainstay)
    sets = ", ".join(SETS)
    raise AssumptionRefusedError(f"no set of contacts {request.value!r}; there are: {sets}")


def requested_source(body: Body, name: str) -> str:
    """Frame of a kinematic source; empty for the base.

    Raises:
        AssumptionRefusedError: no such IMU.
    """
    if name == BASE:
        return ""
    if name not in body.imus:
        known = ", ".join((BASE, *body.imus))
        raise AssumptionRefusedError(f"no kinematic source {name!r}; there are: {known}")
    return body.imus[name]


def source_name(body: Body, frame: str) -> str:
    """What a kinematic source is called in requests."""
    return next((name for name, at in body.imus.items() if at == frame), BASE)


def _of_these_limbs(body: Body, assumption: Assumption) -> Assumption:
    """Without the contacts on limbs that are not in use."""
    moving = set(body.joints)
    kept = tuple(c for c in assumption.contacts if moving & set(body.tree.joints_above(c.frame)))
    return replace(assumption, contacts=kept)


def _known(body: Body, load: KnownLoad) -> KnownWrench:
    try:
        body.tree.link_of(load.frame)
        return KnownWrench(frame=load.frame, wrench=load.wrench, point_m=load.point_m)
    except (DforcError, ServiceError) as error:
        raise AssumptionRefusedError(str(error)) from error


def _contact(body: Body, asked: AssumedContact) -> Contact:
    kind = next((kind for kind in KINDS if kind == asked.kind), None)
    if kind is None:
        raise AssumptionRefusedError(
            f"no kind of contact {asked.kind!r}; there are: {', '.join(KINDS)}"
        )
    try:
        body.tree.link_of(asked.frame)
        return Contact(
            frame=asked.frame, point_m=asked.point_m, kind=kind, direction=asked.direction
        )
    except (DforcError, ServiceError) as error:
        raise AssumptionRefusedError(str(error)) from error
