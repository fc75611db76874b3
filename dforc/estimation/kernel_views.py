"""Views into the flat tables and results, for numba; the order is that of tables.py and Layout."""

from dforc.arrays import Matrix, Vector
from dforc.compiled import compiled
from dforc.estimation.tree_model import Indices

BODY_NUMBERS = 43
HEADER = 8
BODIES, JOINTS, SENSORS, CONTACTS, SUB_MODELS, KNOWN, SOURCE, UNKNOWNS = 0, 1, 2, 3, 4, 5, 6, 7


@compiled
def tree_of(whole: Indices, real: Vector, out: Vector) -> tuple[Indices, Indices, Matrix, Matrix]:
    """Parents, joints, constants and poses of the bodies."""
    nb = whole[BODIES]
    return (
        whole[HEADER : HEADER + nb],
        whole[HEADER + nb : HEADER + 2 * nb],
        real[: BODY_NUMBERS * nb].reshape((nb, BODY_NUMBERS)),
        out[: 12 * nb].reshape((nb, 12)),
    )


@compiled
def cuts_of(whole: Indices) -> tuple[Indices, Indices, Indices]:
    """Sub-model that begins at each body, body of each sensor, sub-model that begins at it."""
    at, m = HEADER + 2 * whole[BODIES], whole[SENSORS]
    start = at + whole[BODIES]
    return whole[at:start], whole[start : start + m], whole[start + m : start + 2 * m]


@compiled
def sub_models_of(whole: Indices) -> tuple[Indices, Indices, Indices, Indices]:
    """Of each sub-model: the one before it, its first body, its method, the end of its members."""
    at, subs = HEADER + 3 * whole[BODIES] + 2 * whole[SENSORS], whole[SUB_MODELS]
    return (
        whole[at : at + subs],
        whole[at + subs : at + 2 * subs],
        whole[at + 2 * subs : at + 3 * subs],
        whole[at + 3 * subs : at + 4 * subs],
    )


@compiled
def contacts_of(whole: Indices) -> tuple[Indices, Indices, Indices, Indices, Indices]:
    """Body and unknowns of each contact; members by sub-model; body, sub-model of the known."""
    at = HEADER + 3 * whole[BODIES] + 2 * whole[SENSORS] + 4 * whole[SUB_MODELS]
    k, known = whole[CONTACTS], whole[KNOWN]
    end = at + 3 * k
    return (
        whole[at : at + k],
        whole[at + k : at + 2 * k],
        whole[at + 2 * k : end],
        whole[end : end + known],
        whole[end + known : end + 2 * known],
    )


@compiled
def given_of(whole: Indices, real: Vector) -> tuple[Matrix, Matrix, Vector, Vector]:
    """Contacts, known wrenches, place of the kinematic source, its motion."""
    k, known = whole[CONTACTS], whole[KNOWN]
    at = BODY_NUMBERS * whole[BODIES]
    middle = at + 6 * k
    end = middle + 6 * known
    return (
        real[at:middle].reshape((k, 6)),
        real[middle:end].reshape((known, 6)),
        real[end : end + 12],
        real[end + 12 : end + 21],
    )


@compiled
def room_of(
    whole: Indices, real: Vector
) -> tuple[Matrix, Matrix, Matrix, Matrix, Matrix, Matrix, Matrix, Matrix]:
    """Room to work: motions, needed and given wrenches, by cut and sub-model, directions, W, V."""
    nb, k, subs, most = whole[BODIES], whole[CONTACTS], whole[SUB_MODELS], whole[UNKNOWNS]
    a = BODY_NUMBERS * nb + 6 * k + 6 * whole[KNOWN] + 21
    b, c, d = a + 9 * nb, a + 15 * nb, a + 21 * nb
    e, f = d + 6 * subs, d + 12 * subs
    g = f + 3 * k
    h = g + 6 * most
    return (
        real[a:b].reshape((nb, 9)),
        real[b:c].reshape((nb, 6)),
        real[c:d].reshape((nb, 6)),
        real[d:e].reshape((subs, 6)),
        real[e:f].reshape((subs, 6)),
        real[f:g].reshape((k, 3)),
        real[g:h].reshape((most, 6)),
        real[h : h + 54].reshape((9, 6)),
    )


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
