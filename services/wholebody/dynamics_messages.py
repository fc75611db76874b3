"""What the whole-body dynamics service and the learner say, and what they are asked.

Sensors go by the names of the robot file, joints by those of the model. Wrenches are six floats,
force then moment; a sensor's are in its own frame and say what the limb beyond it exerts on the
near side, an external one is what the world exerts on the robot, in base axes.
"""

import msgspec

from services.messages import NAN3, Floats, Message, Vector3


class ContactEstimate(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """What touches the robot at one place, as far as the sensors tell."""

    limb: str  # the part that it acts on
    link: str  # of the model; where location is `assumed` or `unsure`, the assumed one
    point_m: Vector3  # base frame
    force_n: Vector3
    moment_nm: Vector3  # about the point
    touching: bool  # with hysteresis; the forces of what does not touch are the estimate's noise
    location: str  # skin | shape | assumed | unsure
    sensor: str = ""  # that feels it first
    since_ns: int = 0  # when touching last changed


class Contacts(Message, frozen=True, kw_only=True):
    """Every contact that the assumption in force allows for."""

    contacts: tuple[ContactEstimate, ...]


class SensorHealth(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One FT sensor: whether it is used, and how well the model explains it."""

    name: str
    ok: bool  # used: no flag, offset known
    flags: tuple[str, ...]  # nan | frozen | saturated | late | missing | uncalibrated
    offset: Floats  # empty before the first calibration
    mean: Floats  # of measured minus predicted, both filtered, over the last seconds
    std: Floats
    task: str = ""  # calibrating | identifying
    samples: int = 0  # of that task so far
    wanted: int = 0
    gain: Floats = ()  # secondary matrix by rows; empty = identity
    reason: str = ""  # of the last task that failed, or what came of it


class DynamicsHealth(Message, frozen=True, kw_only=True):
    """Every FT sensor of the parts in use, and the parts that get no torques."""

    sensors: tuple[SensorHealth, ...]
    silent: tuple[tuple[str, str], ...] = ()  # part without torque estimate, and why
    imu: str = ""  # empty, or what is wrong with the IMU that is the kinematic source


class SubModelStatus(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One piece of the robot between FT sensors: how its unknowns were found."""

    sensors: tuple[str, ...]  # at its border
    links: tuple[str, ...]
    unknowns: int
    rank: int  # below the unknowns: the estimate is the smallest of many
    residual_n: float  # force that the assumption cannot explain
    residual: Floats = ()  # whole, force then moment


class KnownLoad(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """A wrench of the world on the robot that is known, such as what a hand holds."""

    frame: str  # link or frame of the model; its axes
    wrench: tuple[float, float, float, float, float, float]  # moment about the point
    point_m: Vector3 = (0.0, 0.0, 0.0)  # in that frame


class DynamicsModels(Message, frozen=True, kw_only=True):
    """What the estimate assumes, piece by piece, and the robot as a whole."""

    assumption: str  # default | standing | crawling | custom
    source: str  # base, or the IMU that is the kinematic source
    mainstay: bool  # the base is held by something whose wrench is unknown
    sub_models: tuple[SubModelStatus, ...]
    base_wrench: Floats = ()  # on the base, about its origin
    centre_of_mass_m: Vector3 = NAN3  # base frame
    mass_kg: float = 0.0
    known: tuple[KnownLoad, ...] = ()


class SensorSample(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """One sensor's filtered reading beside what the rigid-body model says of the same instant."""

    name: str
    measured: Floats  # offset and gain removed
    predicted: Floats  # if nothing but known loads touched the robot; without the learner's word
    valid: bool
    touching: bool  # something acts on the limb beyond, by the detector of `contacts`


class DynamicsSamples(Message, frozen=True, kw_only=True):
    """What a learner learns from: joints and sensors with one and the same delay."""

    joints: tuple[str, ...]
    q_rad: Floats
    dq_rad_s: Floats
    ddq_rad_s2: Floats
    delay_s: float  # from the instant that the values belong to, to stamp_ns
    sensors: tuple[SensorSample, ...]


class AssumedContact(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Somewhere the world may act on the robot."""

    frame: str  # link or frame of the model
    point_m: Vector3 = (0.0, 0.0, 0.0)  # in that frame
    kind: str = "wrench"  # wrench | force | direction
    direction: Vector3 | None = None  # unit, frame axes; for kind direction


class DynamicsRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Something for the dynamics service to do; work that takes time is told in dynamics/health.

    calibrate   find the offset of the sensors (none named: all); refused in contact
    reset       forget offset and found gain of the sensors: no torques until calibrated
    assume      value: default, standing, crawling, or custom with `contacts` and `mainstay`; with
                what is `known` to act on the robot, none named: nothing
    source      value: base, or the name of an IMU
    identify    value: start, solve or discard; `sensors`: gain matrix and offset from a pose sweep
    """

    action: str
    sensors: tuple[str, ...] = ()
    value: str = ""
    samples: int = 200
    contacts: tuple[AssumedContact, ...] = ()
    mainstay: bool = True
    known: tuple[KnownLoad, ...] = ()


class LearnedWrench(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Correction of one sensor: to be added to the model's prediction of its reading."""

    name: str
    wrench: Floats
    std: Floats = ()  # of the error that is left, where the learner knows it


class LearnedWrenches(Message, frozen=True, kw_only=True):
    """The learner's word on the newest dynamics/samples."""

    samples_stamp_ns: int  # of the samples that it answers
    corrections: tuple[LearnedWrench, ...]


class SensorLearning(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """How learning goes for one sensor."""

    name: str
    updates: int
    gated: bool  # held back, because something may touch the limb
    error_n: float  # RMS of the force that is left, model and correction taken off
    model_error_n: float  # RMS with the model alone
    reason: str = ""  # why it does not learn


class LearnerStatus(Message, frozen=True, kw_only=True):
    """The learner as a whole."""

    state: str  # waiting | learning | frozen
    features: int
    sensors: tuple[SensorLearning, ...]
    snapshot: str = ""  # where the state was last saved to or restored from
    reason: str = ""


class LearnerRequest(msgspec.Struct, frozen=True, kw_only=True, array_like=True):
    """Something for the learner to do.

    save, restore: value = file; reset: forget the sensors' (none named: all) learning; freeze,
    resume: stop and go on learning, predicting all the while.
    """

    action: str
    sensors: tuple[str, ...] = ()
    value: str = ""
