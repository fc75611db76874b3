"""What the HAL reports of each fault: the rows of test_fault_switches.py.

Coupled partners are concerned too (can-protocol 9.4, 10.3): they are named in the rows.
"""

import re
from dataclasses import dataclass

from firmware_sim.switch_table import FaultSpec

SHOULDER = "board r_shoulder (bus 2, address 1)"
ELBOW = "board r_elbow (bus 2, address 2)"
FOREARM = "board r_forearm (bus 2, address 3)"
STRAIN = "board r_arm_strain (bus 2, address 13)"
MAIS = "board r_mais (bus 6, address 14)"
SKIN = "board r_hand_skin (bus 8, address 14)"
ARM_BUS = {"r_shoulder", "r_elbow", "r_forearm", "r_arm_strain"}
SHOULDER_JOINTS = {"r_shoulder_pitch", "r_shoulder_roll"}
ELBOW_JOINTS = {"r_shoulder_yaw", "r_elbow"}
FOREARM_JOINTS = {"r_wrist_prosup", "r_wrist_pitch", "r_wrist_yaw"}
WRIST = {"r_wrist_pitch", "r_wrist_yaw"}  # coupled: enabled and disabled together
ARM_JOINTS = SHOULDER_JOINTS | ELBOW_JOINTS | FOREARM_JOINTS
TORSO_JOINTS = {"torso_yaw", "torso_roll", "torso_pitch"}
HAND_JOINTS = {
    *("r_thumb_oppose", "r_thumb_proximal", "r_thumb_distal", "r_index_proximal"),
    *("r_index_distal", "r_middle_proximal", "r_middle_distal", "r_ring_little"),
}
LOWER = "r_shoulder_yaw"  # its board hears the frames of the shoulder's, and the other way round
NO_SHOULDER = "r_shoulder_yaw in hardware fault: coupled board r_shoulder silent"
NO_ELBOW = "r_shoulder_(pitch|roll) in hardware fault: coupled board r_elbow silent"
RESTARTED = "has restarted; it is configured again"
KEPT = "is back; it has kept its settings"


def silent(board: str) -> str:
    return f"{board} silent for 0.[01].. s"


@dataclass(frozen=True, kw_only=True)
class Row:
    """Texts are patterns; each report must match one, and each pattern a report.

    `within_ms` is when the first report has come. `evidence` stands in a frame attached to one.
    """

    spec: FaultSpec
    told: tuple[str, ...]
    partners: tuple[str, ...] = ()  # told too where the robot file couples the shoulder's boards
    partners_after: tuple[str, ...] = ()
    may: tuple[str, ...] = ()  # said besides, or not
    within_ms: float = 100.0
    ms: int = 150
    evidence: str = ""
    boards: frozenset[str] | set[str] = frozenset()
    joints: frozenset[str] | set[str] = frozenset()
    after: tuple[str, ...] = ()
    after_ms: int = 150
    moves: bool = True  # the joints are sent somewhere afterwards

    @property
    def name(self) -> str:
        spec = self.spec
        place = "" if spec.bus is None else f"_{spec.bus}"
        return spec.kind + place + ("" if spec.address is None else f"_{spec.address}")


def at(kind: str, bus: int | None = 2, address: int | None = None, **rest: int | None) -> FaultSpec:
    return FaultSpec(
        kind=kind,
        bus=bus,
        address=address,
        axis=rest.get("axis"),
        value=rest.get("value"),
        can_id=rest.get("can_id"),
        count=rest.get("count") or 0,
        milliseconds=rest.get("milliseconds") or 0,
    )


ARM_ROWS = (
    Row(
        spec=at("encoder", 2, 1, axis=0),
        told=(
            "r_shoulder_pitch: absolute encoder read error",
            "r_shoulder_pitch in hardware fault: absolute encoder read error",
        ),
        within_ms=7,
        evidence="fault0=ENCODER",
        joints={"r_shoulder_pitch"},
    ),
    Row(
        spec=at("hall", 2, 2, axis=1, value=5),  # code bits 0 and 2: 0x10 and 0x80
        told=("r_elbow: .*Hall sensor error.*", "r_elbow in hardware fault: .*Hall sensor error.*"),
        within_ms=7,
        evidence="fault1=HALL_A|HALL_C",
        joints={"r_elbow"},
    ),
    Row(
        spec=at("overheat", 2, 1, axis=1),
        told=(
            "r_shoulder_roll in hardware fault: over-temperature axis 1",
            re.escape(f"{SHOULDER}: over-temperature axis 1"),
        ),
        within_ms=12,  # looked for each 5 ms
        evidence="board_status=OVERTEMPERATURE_1",
        joints={"r_shoulder_roll"},
    ),
    Row(
        spec=at("overcurrent", 2, 1, axis=1),
        told=(
            "r_shoulder_roll: over-current or I2T trip",
            "r_shoulder_roll in hardware fault: over-current or I2T trip",
        ),
        within_ms=7,
        evidence="fault1=OVERCURRENT",
        joints={"r_shoulder_roll"},
    ),
    Row(
        spec=at("overcurrent", 2, 3, axis=1, value=8000),  # I2T: 1.8e9 / (8000 - 800)^2 = 35 ms
        told=(
            "r_wrist_pitch: over-current or I2T trip",
            "r_wrist_pitch in hardware fault: over-current or I2T trip; "
            "r_wrist_yaw coupled with it goes idle",
        ),
        may=("r_wrist_yaw is idle: its coupled partner r_wrist_pitch faulted",),
        within_ms=45,
        evidence="fault1=OVERCURRENT",
        joints=WRIST,
    ),
    Row(
        spec=at("estop", 2, 2),
        told=(
            re.escape(f"{ELBOW}: emergency button pressed"),
            "r_shoulder_yaw went idle by itself: emergency button pressed",
            "r_elbow went idle by itself: emergency button pressed",
        ),
        within_ms=7,
        joints=ELBOW_JOINTS,
    ),
    Row(
        spec=at("estop", None),
        told=(
            r"board \w+ \(bus [02], address [12356]\): emergency button pressed",
            r"\w+ went idle by itself: emergency button pressed",
        ),
        within_ms=7,
        joints=ARM_JOINTS | TORSO_JOINTS,
    ),
    Row(
        spec=at("overrun", 2, 3),
        told=(re.escape(f"{FOREARM}: control loop longer than 1 ms"),),
        within_ms=7,
    ),
    Row(
        spec=at("no_power", 2, 1),
        told=(silent(re.escape(SHOULDER)),),
        partners=(NO_SHOULDER,),
        evidence="POSITION",
        boards={"r_shoulder"},
        joints=SHOULDER_JOINTS | {LOWER},
        after=(re.escape(f"{SHOULDER} {RESTARTED}, its axes are idle"),),
        after_ms=400,
    ),
    Row(
        spec=at("reboot", 2, 2, milliseconds=20),
        told=(
            silent(re.escape(ELBOW)),
            re.escape(f"{ELBOW} {RESTARTED}, its axes are idle"),
        ),
        partners=(NO_ELBOW,),
        ms=400,
        boards={"r_elbow"},
        joints=ELBOW_JOINTS | SHOULDER_JOINTS,
    ),
    Row(
        spec=at("reboot", 2, 13),
        told=(
            re.escape(f"{STRAIN} has restarted"),
            silent(re.escape(STRAIN)),
            re.escape(f"{STRAIN} {RESTARTED}"),
        ),
        within_ms=3,
        ms=400,
        boards={"r_arm_strain"},
    ),
    Row(
        spec=at("unplug", 2, 2),
        told=(silent(re.escape(ELBOW)),),
        partners=(NO_ELBOW,),
        evidence="POSITION",
        boards={"r_elbow"},
        joints=ELBOW_JOINTS | SHOULDER_JOINTS,
        partners_after=("r_shoulder_yaw in hardware fault: .*",),  # it ran on and heard nobody
        after=(re.escape(f"{ELBOW} {KEPT}"),),
    ),
    Row(
        spec=at("unplug", 2),
        told=(
            *(silent(re.escape(board)) for board in (SHOULDER, ELBOW, FOREARM, STRAIN)),
            "bus 2 is deserted: nobody acknowledges, check its cable, power and termination",
        ),
        boards=ARM_BUS,
        joints=ARM_JOINTS,
        after=(
            "bus 2 is back",
            *(re.escape(f"{board} {KEPT}") for board in (SHOULDER, ELBOW, FOREARM, STRAIN)),
        ),
    ),
    Row(
        spec=at("bus_off", 2, 1),
        told=(silent(re.escape(SHOULDER)),),
        partners=(NO_SHOULDER,),
        boards={"r_shoulder"},
        joints=SHOULDER_JOINTS | {LOWER},
        after=(
            "r_shoulder_(pitch|roll) in hardware fault: (CAN bus-off|no fault bit.*)",
            re.escape(f"{SHOULDER}: CAN bus-off"),
            re.escape(f"{SHOULDER} {KEPT}"),
        ),
    ),
    Row(
        spec=at("drop", 2, 1, can_id=0x111),
        told=(re.escape(SHOULDER) + " sends no POSITION for 0.09. s",),
        partners=(NO_SHOULDER,),
        evidence="PID_VAL",
        boards={"r_shoulder"},
        joints={LOWER},
        after=(re.escape(f"{SHOULDER} sends POSITION again"),),
    ),
    Row(
        spec=at("delay", 2, 3, milliseconds=120),
        told=(silent(re.escape(FOREARM)), re.escape(f"{FOREARM} {KEPT}")),
        ms=1300,  # its answers take 240 ms each
        boards={"r_forearm"},
        joints=FOREARM_JOINTS,
    ),
    Row(
        spec=at("duplicate", 2, 13),
        told=("r_arm_ft: (force|torque) frame without its (torque|force) frame.*",),
        within_ms=5,
    ),
    Row(
        spec=at("saturate", 2, 13, value=2),
        told=("r_arm_ft saturated: Fz high",),
        within_ms=3,
    ),
    Row(
        spec=at("freeze", 2, 13),
        told=("r_arm_ft is frozen: one constant sample for 0.100 s.*",),
        within_ms=110,
        after=("r_arm_ft is no longer frozen",),
    ),
    Row(
        spec=at("mute", 2, 13),
        told=(silent(re.escape(STRAIN)),),
        boards={"r_arm_strain"},
        ms=100,
        after=(re.escape(f"{STRAIN} {KEPT}"),),
    ),
)
HAND_ROWS = (
    Row(
        spec=at("mute", 6, 14),
        told=(
            silent(re.escape(MAIS))
            + ":.* r_hand_proximal, r_hand_distal .*check the cable and power of the MAIS",
            r"r_\w+ in hardware fault: MAIS r_mais silent, check its cable and power.*",
        ),
        may=(r"board r_hand_\w+ \(bus 6, address [57]\) says: MAIS error.*",),
        boards={"r_mais"},
        joints=HAND_JOINTS,
        moves=False,
        after=(re.escape(f"{MAIS} {KEPT}"),),
    ),
    Row(
        spec=at("hall", 6, 7, axis=1, value=1),
        told=(
            "r_middle_proximal: Hall sensor error",
            "r_middle_proximal in hardware fault: Hall sensor error",
        ),
        within_ms=7,
        joints={"r_middle_proximal"},
        moves=False,
    ),
)
SKIN_ROWS = (
    Row(
        spec=at("triangle", 8, 14, value=3),
        told=(re.escape(SKIN) + ": .*no answer.*triangle 3.*",),
        within_ms=45,  # once a period
        after=(re.escape(SKIN) + ": .*every triangle answers again",),
        after_ms=1500,
    ),
    Row(
        spec=at("mute", 8, 14),
        told=(
            silent(re.escape(SKIN)),
            re.escape(f"{SKIN} answers but sends no skin frames"),
        ),
        within_ms=135,  # three periods of 40 ms, looked for each 10 ms
        ms=1000,
        boards={"r_hand_skin"},
        after=(re.escape(f"{SKIN} {RESTARTED}"),),
        after_ms=400,
    ),
)
