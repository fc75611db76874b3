"""Where each word of an axis and of a board stands in the arrays of a bank.

Every word is a signed 64-bit integer; flags are 0 or 1. Ticks are encoder ticks, torque units as in
can-protocol 9.1, times in milliseconds.
"""

MEAN_SAMPLES = 10  # at most
WINDOW_MS = 29  # of the speed estimate, at most
STICTION_WINDOW_MS = 29  # the sign of the commanded velocity is taken over this time

# A mean of the last samples, relative to its start.
MEAN_NEXT, MEAN_SUM, MEAN_LIVE, MEAN_VALUES = range(4)
MEAN_WORDS = MEAN_VALUES + MEAN_SAMPLES

# A loop, relative to its start: gains and limits, then its memory.
(
    KP,
    KD,
    KI,
    SHIFT,
    OFFSET,
    INTEGRAL_LIMIT,
    OUTPUT_LIMIT,
    ERROR,
    INTEGRAL,  # not shifted
    INTEGRAL_BEFORE,  # of the last millisecond
    DERIVATIVE,  # a mean
) = range(11)
PID_WORDS = DERIVATIVE + MEAN_WORDS

_NAMES = 88
(
    # Wires: what the rig sets and reads.
    RAW_ENCODER,
    CURRENT_MA,
    EXTERNAL_FAULT,
    ENCODER_FAULT,
    HALL_FAULT,  # Hall error code, bits 0..2
    OVERHEATED,
    PORT_PWM,
    PORT_ENABLED,
    # Constants of the board and its firmware.
    MAX_DUTY,
    DUTY_STEP,
    SAMPLES,  # of derivatives
    SPEED_WINDOW,
    SCALES_SPEED,
    DAMPS_SPEED,
    PULSES_STICTION,
    DROPS_INTEGRAL,  # the integral falls to its limit, unshifted, when it reaches it
    I2T_SHIFT,
    I2T_TRIP,
    TRIP_MA,
    ENCODER_MASK,
    FROM_HALL,  # position comes from Hall sensors, not from the encoder
    HALL_TICKS,
    BOARD,  # row of the board
    BOARD_FIRST,  # row of the board's axis 0
    MOTOR_LOW,  # the motor is not driven below and above these counts of its encoder
    MOTOR_HIGH,
    PEERS,  # rows enabled and disabled together with this one, as bits counted from BOARD_FIRST
    WATCHES_PARTNER,  # faults when the partner board is silent
    # Modes and faults.
    MODE,
    COMPLIANT,
    FORCE_CONTROLLED,  # the torque law runs, now or as soon as the mode is entered
    UNDEFINED_MODE,
    ENABLED,  # what the board asks of the bridge
    WAS_ENABLED,  # the same at the end of the millisecond before
    CALIBRATED,
    PID_FLAGS,
    FAULTS_ONCE,  # AxisFault bits reported once, then cleared
    FAULT_ENTRIES,  # times this axis went into HW_FAULT
    STATUS_KEY,  # changes with whatever a STATUS frame would say
    # Measured.
    ENCODER_OFFSET,
    ENCODER,  # of this encoder, before the decoupling
    POSITION,
    STEP,  # ticks of the last millisecond
    MOVED,  # ticks in the speed window
    SPEED,  # as the board estimates it
    SPEED_SHIFT,
    I2T,
    CURRENT_LIMIT_MA,
    # PWM.
    PWM_WANTED,  # before the coupling of motors
    PWM,  # after every limit
    DUTY,  # what the bridge has reached
    PWM_LIMIT,
    DUTY_LIMIT,  # the smaller of it and MAX_DUTY
    OPENLOOP_PWM,
    # Reference.
    REFERENCE,
    LOW,
    HIGH,
    ACTIVE,
    VELOCITY,  # (tick/ms) * 2^VELOCITY_SHIFT
    VELOCITY_TARGET,
    VELOCITY_SHIFT,
    VELOCITY_TIMEOUT,
    VELOCITY_AGE,
    ACCELERATION,  # (tick/ms^2) * 2^VELOCITY_SHIFT
    FRACTION,  # of a tick, in 2^-VELOCITY_SHIFT
    DELTA,  # of the move, 0 when there is none
    PROGRESS,
    ELAPSED,
    DURATION,
    # Position loop's stiction; settings that only answer.
    STICTION_UP,
    STICTION_DOWN,
    MAX_VELOCITY,
    VELOCITY_SETTING,
    ACCELERATION_SETTING,
    # Torque.
    DESIRED_TORQUE,
    TORQUE_SOURCE,  # row of the virtual sensor in the bank, -1 = none
    TORQUE_CHANNEL,
    EXTRA_DAMPING,  # debug parameter 7
    FILTER,
    LOW_PASS,  # in 1/65536 counts
    KFF,
    KFF_SHIFT,
    KTAU,
    KTAU_SHIFT,
    BEMF,
    BEMF_SHIFT,
    TORQUE_STICTION_UP,
    TORQUE_STICTION_DOWN,
) = range(_NAMES)

# Impedance.
STIFFNESS, DAMPING, IMPEDANCE_OFFSET, DEVIATION = range(_NAMES, _NAMES + 4)
DAMPER = DEVIATION + 1  # a mean
POSITION_PID = DAMPER + MEAN_WORDS
TORQUE_PID = POSITION_PID + PID_WORDS
HISTORY = TORQUE_PID + PID_WORDS  # positions in the speed window
REFERENCE_HISTORY = HISTORY + WINDOW_MS
AXIS_WORDS = REFERENCE_HISTORY + STICTION_WINDOW_MS

# Words of a board.
(
    FIRST,  # row of its axis 0
    AXES,
    RUNNING,
    MS,  # since power-up
    ENCODERS_COUPLED,
    MOTORS_COUPLED,
    PARTNER_SILENT,
    PARTNER_DUTY_0,
    PARTNER_DUTY_1,
    PARTNER_POSITION_0,
    PARTNER_POSITION_1,
) = range(11)
BOARD_WORDS = PARTNER_POSITION_1 + 1

# Coefficients of an axis: on the board's axes, then on the two words of the partner.
MOST_AXES = 4
COEFFICIENTS = MOST_AXES + 2
FOR_MOTOR, FOR_ENCODER = range(2)

SOURCES = 16  # virtual torque sensors that a board may hear
