"""The one place that names streams and requests, with their rates.

Keys are `<robot>/<place>/<name>`; `place` is a part, a sensor or a service.
"""

from services.core.stream import Call, PlacedStream, Stream
from services.emulated.messages import FaultRequest, PlantTruth, PushRequest
from services.fields.messages import FieldReply, FieldRequest, FieldStatus
from services.messages import (
    CartesianStatus,
    DynamicsStatus,
    FtRequest,
    Goal,
    Hall,
    IkSolution,
    ImpedanceOffset,
    Imu,
    Inertial,
    JointCommand,
    JointState,
    Objects,
    Reply,
    ServiceStats,
    Skin,
    TorqueEstimate,
    VirtualPoint,
    Wrench,
)
from services.reaching.cartesian_messages import (
    CartesianEvent,
    CartesianReply,
    CartesianRequest,
)
from services.reaching.messages import IkReply, IkRequest, IkStatusReport, SetupInUse
from services.robot_messages import RobotRequest, RobotStatus
from services.wholebody.dynamics_messages import (
    Contacts,
    DynamicsHealth,
    DynamicsModels,
    DynamicsRequest,
    DynamicsSamples,
    LearnedWrenches,
    LearnerRequest,
    LearnerStatus,
)

# per part; rates of the first, of wrench and of plant_truth are lower live: robot file, [rates]
JOINT_STATE = PlacedStream("joint_state", JointState, rate_hz=250)
JOINT_COMMAND = PlacedStream("joint_command", JointCommand, rate_hz=100)
TORQUE_ESTIMATE = PlacedStream("torque_estimate", TorqueEstimate, rate_hz=1000)
IMPEDANCE_OFFSET = PlacedStream("impedance_offset", ImpedanceOffset, rate_hz=100)

# per FT sensor
WRENCH = PlacedStream("wrench", Wrench, rate_hz=1000)

# per board
HALL = PlacedStream("hall", Hall, rate_hz=100)
SKIN = PlacedStream("skin", Skin, rate_hz=25)
INERTIAL = PlacedStream("inertial", Inertial, rate_hz=100)
IMU = PlacedStream("imu", Imu, rate_hz=100)

# per process
STATS = PlacedStream("stats", ServiceStats, rate_hz=1)

GOAL = Stream("field/goal", Goal, rate_hz=0)
OBJECTS = Stream("field/objects", Objects, rate_hz=0)
FIELD_STATUS = Stream("field/status", FieldStatus, rate_hz=20)
VIRTUAL_POINT = Stream("field/virtual_point", VirtualPoint, rate_hz=100)
IK_SOLUTION = Stream("ik/ik_solution", IkSolution, rate_hz=100)
IK_STATUS = Stream("ik/status", IkStatusReport, rate_hz=10)
CARTESIAN_SETUP = Stream("cartesian/setup", SetupInUse, rate_hz=0)
DYNAMICS_STATUS = Stream("dynamics/status", DynamicsStatus, rate_hz=50)
EXTERNAL = Stream("dynamics/contacts", Contacts, rate_hz=100)
DYNAMICS_SAMPLES = Stream("dynamics/samples", DynamicsSamples, rate_hz=100)
DYNAMICS_MODELS = Stream("dynamics/models", DynamicsModels, rate_hz=10)
DYNAMICS_HEALTH = Stream("dynamics/health", DynamicsHealth, rate_hz=10)
LEARNED = Stream("learner/prediction", LearnedWrenches, rate_hz=100)
LEARNER_STATUS = Stream("learner/status", LearnerStatus, rate_hz=10)
CARTESIAN_STATUS = Stream("cartesian/status", CartesianStatus, rate_hz=50)
# as they come; not 0, or a late joiner would be told of a motion that is over
CARTESIAN_EVENTS = Stream("cartesian/events", CartesianEvent, rate_hz=1)
ROBOT_STATUS = Stream("robot/status", RobotStatus, rate_hz=50)
PLANT_TRUTH = Stream("boards/plant_truth", PlantTruth, rate_hz=200)

ROBOT_CALL = Call("robot/request", RobotRequest, Reply)
GUARD_CALL = Call("guard/request", RobotRequest, Reply)
FT_CALL = Call("dynamics/zero_ft", FtRequest, Reply)
DYNAMICS_CALL = Call("dynamics/request", DynamicsRequest, Reply)
LEARNER_CALL = Call("learner/request", LearnerRequest, Reply)
IK_CALL = Call("ik/request", IkRequest, IkReply, timeout_s=10.0)
PUSH_CALL = Call("boards/push", PushRequest, Reply)
FAULT_CALL = Call("boards/fault", FaultRequest, Reply)
FIELD_CALL = Call("field/request", FieldRequest, FieldReply, timeout_s=100.0)
CARTESIAN_CALL = Call("cartesian/request", CartesianRequest, CartesianReply)
