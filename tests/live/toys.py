"""Toy processes for the tests of the live side: `python -m tests.live.toys NAME ...`."""

import os
import signal
import sys

from hal.buses.bus import FrameBus
from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Period, Service
from services.messages import Goal, Objects, Reply, RobotRequest, RobotStatus, VirtualPoint
from services.streams import GOAL, OBJECTS, ROBOT_CALL, ROBOT_STATUS, VIRTUAL_POINT
