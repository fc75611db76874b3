"""The emulated robot: boards on their CAN buses, and the physics that they drive.

Reads   nothing but CAN frames
Writes  plant_truth (for reports and experiments; no controller reads it)
Serves  boards/push: a force on a point of any link, as a person would push it
        boards/fault: a fault of a bus, a board, a drive or a sensor, on or off
If the buses go away the boards fault as real ones do, and the limbs go limp.
"""

from collections.abc import Mapping

from firmware_sim.boards.warm import warm
from firmware_sim.network import RigError
from firmware_sim.rig import Rig
from firmware_sim.switch_table import FaultSpec, SwitchError
from hal.buses.bus import FrameBus
from services.config import load_robot
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.emulated.emulation import rig_spec
from services.emulated.messages import FaultRequest, PlantTruth, PushRequest
from services.messages import Reply
from services.streams import FAULT_CALL, PLANT_TRUTH, PUSH_CALL

TICK_S = 0.001


class Boards(Service):
    """Runs every emulated board one millisecond per step."""

    reads = ()
    writes = (PLANT_TRUTH,)
    serves = (PUSH_CALL, FAULT_CALL)
    trigger = Period(TICK_S)

    def __init__(self, rig: Rig, buses: Mapping[int, FrameBus], truth_hz: int) -> None:
        self._rig = rig
        self._buses = buses
        self._truth_every = max(1, round(1.0 / (TICK_S * truth_hz)))
        self._ticks = 0
        self._frames = 0

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        """One millisecond of every board and of the plant."""
        for token, push in inputs.requests(PUSH_CALL):
            outputs.reply(PUSH_CALL, token, self._push(push))
        for token, fault in inputs.requests(FAULT_CALL):
            outputs.reply(FAULT_CALL, token, self._switch(fault))
        received = {number: bus.receive_frames() for number, bus in self._buses.items()}
        sent = self._rig.step(received)
        for number, frames in sent.items():
            if frames:
                self._buses[number].send_frames(frames)
                self._frames += len(frames)
        self._ticks += 1
        if self._ticks % self._truth_every == 0:
            outputs.put(PLANT_TRUTH, self._truth(now_ns))

    def _push(self, push: PushRequest) -> Reply:
        try:
            self._rig.push(push.force_n, push.duration_s, push.frame, push.point_m)
        except RigError as error:
            return Reply(ok=False, reason=str(error))
        return Reply(ok=True)

    def _switch(self, fault: FaultRequest) -> Reply:
        spec = FaultSpec(
            kind=fault.kind,
            bus=fault.bus,
            address=fault.address,
            axis=fault.axis,
            value=fault.value,
            can_id=fault.can_id,
            count=fault.count,
            share=fault.share,
            seed=fault.seed,
            milliseconds=fault.milliseconds,
        )
        switches = self._rig.switches
        try:
            done = switches.switch_on(spec) if fault.on else switches.switch_off(spec)
        except SwitchError as error:
            return Reply(ok=False, reason=str(error))
        return Reply(ok=True, reason=done)

    def _truth(self, now_ns: int) -> PlantTruth:
        rig = self._rig
        position, rotation = rig.tip_pose()
        return PlantTruth(
            stamp_ns=now_ns,
            joints=rig.joints,
            q_rad=rig.q_rad,
            dq_rad_s=rig.dq_rad_s,
            tau_nm=rig.motor_torque_nm,
            tip_position_m=position,
            tip_rotation_rad=rotation,
            limit_violations=rig.limit_violations,
            board_faults=rig.board_faults,
            ticks=self._ticks,
            frames=self._frames,
            frames_lost=sum(bus.frames_lost for bus in self._buses.values()),
            limits_waiting=rig.limits_waiting,
        )


def build(context: Context) -> Boards:
    """Open every bus of the robot file and put its boards on them."""
    robot = load_robot(context.robot)
    buses = {bus.number: context.open_bus(bus.number, bus.channel) for bus in robot.buses.values()}
    rig = Rig(rig_spec(robot, context.seed))
    warm()
    rig.step({})  # the first millisecond also loads the plant's arithmetic
    return Boards(rig, buses, robot.rates["plant_truth"].live_hz)


if __name__ == "__main__":
    raise SystemExit(run_process("boards", build))
