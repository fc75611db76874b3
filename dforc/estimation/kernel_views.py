"""Views into the flat tables and results, for numba; the order is that of tables.py and Layout."""

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.estimation.tables import BODY_NUMBERS, SOURCE_NUMBERS
from dforc.estimation.tree_model import Indices, Places

CONTACT_NUMBERS = 9
HEADER = 8
BODIES, JOINTS, SENSORS, CONTACTS, SUB_MODELS, KNOWN, SOURCE, UNKNOWNS = 0, 1, 2, 3, 4, 5, 6, 7


@compiled
def tree_of(whole: Indices, real: Vector, out: Vector) -> tuple[Places, Matrix, Matrix]:
    """Parent, joint, sub-model that begins there; constants and room; pose: of every body."""
    nb = whole[BODIES]
    return (
        whole[HEADER : HEADER + 3 * nb].reshape((nb, 3)),
        real[: BODY_NUMBERS * nb].reshape((nb, BODY_NUMBERS)),
        out[: 12 * nb].reshape((nb, 12)),
    )


@compiled
def plan_of(whole: Indices) -> tuple[Places, Places, Places, Indices, Places]:
    """What there is of each kind, a row for each.

    Sensors: body, sub-model that begins there. Sub-models: the one before, first body, method, end
    of its members. Contacts: body, unknowns. Members of the sub-models. Known: body, sub-model.
    """
    m, k, subs, known = whole[SENSORS], whole[CONTACTS], whole[SUB_MODELS], whole[KNOWN]
    a = HEADER + 3 * whole[BODIES]
    b = a + 2 * m
    c = b + 4 * subs
    d = c + 2 * k
    e = d + k
    return (
        whole[a:b].reshape((m, 2)),
        whole[b:c].reshape((subs, 4)),
        whole[c:d].reshape((k, 2)),
        whole[d:e],
        whole[e : e + 2 * known].reshape((known, 2)),
    )


@compiled
def room_of(whole: Indices, real: Vector) -> tuple[Vector, Matrix, Matrix, Matrix, Vector]:
    """The source, contacts, known wrenches, sub-models, and room for `solve_several`.

    Contacts: point, direction, direction in the base. Sub-models: wrench beyond the cut, missing.
    """
    k, known, subs = whole[CONTACTS], whole[KNOWN], whole[SUB_MODELS]
    a = BODY_NUMBERS * whole[BODIES]
    b = a + SOURCE_NUMBERS
    c = b + CONTACT_NUMBERS * k
    d = c + 6 * known
    e = d + 12 * subs
    return (
        real[a:b],
        real[b:c].reshape((k, CONTACT_NUMBERS)),
        real[c:d].reshape((known, 6)),
        real[d:e].reshape((subs, 12)),
        real[e:],
    )


@compiled
def scratch_of(whole: Indices, room: Vector) -> tuple[Matrix, Matrix]:
    """A row for each unknown of the largest sub-model, and nine more."""
    end = 6 * whole[UNKNOWNS]
    return room[:end].reshape((whole[UNKNOWNS], 6)), room[end : end + 54].reshape((9, 6))


@compiled
def results_of(
    whole: Indices, out: Vector
) -> tuple[Vector, Matrix, Matrix, Vector, Matrix, Matrix]:
    """Torques, wrenches and points of the contacts, base wrench, internal wrenches, sub-models."""
    n, m, k = whole[JOINTS], whole[SENSORS], whole[CONTACTS]
    a = 12 * whole[BODIES]
    b = a + n
    c, d = b + 6 * k, b + 9 * k
    e = d + 6
    f = e + 6 * m
    return (
        out[a:b],
        out[b:c].reshape((k, 6)),
        out[c:d].reshape((k, 3)),
        out[d:e],
        out[e:f].reshape((m, 6)),
        out[f : f + 7 * (m + 1)].reshape((m + 1, 7)),
    )
