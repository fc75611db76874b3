"""What the dynamics service answers to a request; work that takes time goes on afterwards."""

from dataclasses import replace
from typing import TYPE_CHECKING

from dforc.errors import DforcError
from services.core.errors import ServiceError
from services.core.service import Inputs, Outputs
from services.messages import Reply
from services.streams import DYNAMICS_CALL, FT_CALL
from services.wholebody.assumed_contacts import requested_assumption, requested_source
from services.wholebody.dynamics_messages import DynamicsRequest

if TYPE_CHECKING:
    from services.dynamics import Dynamics

ACTIONS = ("calibrate", "reset", "assume", "source", "identify")
STAGES = ("start", "solve", "discard")


def answer(dynamics: "Dynamics", now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
    """Answer all requests that have arrived."""
    for token, asked in inputs.requests(FT_CALL):
        request = DynamicsRequest(action="calibrate", sensors=asked.sensors, samples=asked.samples)
        outputs.reply(FT_CALL, token, _reply(dynamics, now_ns, request))
    for token, request in inputs.requests(DYNAMICS_CALL):
        outputs.reply(DYNAMICS_CALL, token, _reply(dynamics, now_ns, request))


def _reply(dynamics: "Dynamics", now_ns: int, request: DynamicsRequest) -> Reply:
    try:
        return Reply(ok=True, reason=_carry_out(dynamics, now_ns, request))
    except (ServiceError, DforcError) as error:
        return Reply(ok=False, reason=str(error))


def _carry_out(dynamics: "Dynamics", now_ns: int, request: DynamicsRequest) -> str:
    tasks = dynamics.tasks
    if request.action == "calibrate":
        touched = dynamics.filtered.is_pressed
        around = dynamics.gate.trouble_around
        tasks.calibrate(request.sensors, request.samples, now_ns, around, touched)
    elif request.action == "reset":
        tasks.reset(request.sensors)
    elif request.action == "assume":
        frame = dynamics.source.frame
        assumption = requested_assumption(dynamics.body, request, frame)
        dynamics.assume(request.value, assumption)
    elif request.action == "source":
        frame = requested_source(dynamics.body, request.value)
        assumption = replace(dynamics.assumption, source=frame)
        dynamics.assume(dynamics.assumption_name, assumption)
    elif request.action == "identify":
        return _identify(dynamics, request)
    else:
        raise ServiceError(f"unknown action {request.action!r}; there are: {', '.join(ACTIONS)}")
    return ""


def _identify(dynamics: "Dynamics", request: DynamicsRequest) -> str:
    tasks = dynamics.tasks
    if request.value == "start":
        tasks.sweep(request.sensors, dynamics.filtered.is_pressed)
    elif request.value == "solve":
        return tasks.solve(request.sensors)
    elif request.value == "discard":
        tasks.discard(request.sensors)
    else:
        raise ServiceError(f"identify: unknown {request.value!r}; there are: {', '.join(STAGES)}")
    return ""
