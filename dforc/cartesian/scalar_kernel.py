"""Small reductions over vectors, for numba: one call each where NumPy takes three."""

import math

from dforc.arrays import Vector
from dforc.compiled import compiled


@compiled
def largest(values: Vector) -> float:
    """Largest size of an element."""
    most = 0.0
    for value in values:
        most = max(most, abs(value))
    return most


@compiled
def largest_difference(a: Vector, b: Vector) -> float:
    """Largest size of an element of a - b."""
    most = 0.0
    for i in range(len(a)):
        most = max(most, abs(a[i] - b[i]))
    return most


@compiled
def weighted_distance(a: Vector, b: Vector, weights: Vector) -> float:
    """Length of weights times (a - b), element by element."""
    total = 0.0
    for i in range(len(a)):
        part = weights[i] * (a[i] - b[i])
        total += part * part
    return math.sqrt(total)


@compiled
def clamped_reference(
    q: Vector,
    offset: Vector,
    lead: Vector,
    lower: Vector,
    upper: Vector,
    inside: Vector,
    reference: Vector,
) -> bool:
    """Offset cut so that q + offset is within the range, or as near as q is; and the reference.

    `inside` becomes that offset and `reference` q + offset + lead, cut likewise. Whether any
    offset was cut.
    """
    cut = False
    for i in range(len(q)):
        least, most = min(lower[i], q[i]), max(upper[i], q[i])
        wanted = q[i] + offset[i]
        kept = min(max(wanted, least), most)
        cut = cut or kept != wanted
        inside[i] = offset[i] if kept == wanted else kept - q[i]
        reference[i] = min(max(kept + lead[i], least), most)
    return cut
