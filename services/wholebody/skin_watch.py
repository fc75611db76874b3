"""Where the skin is pressed, by the FT sensor that feels the same touch."""

from dforc.contacts.skin import SkinContact, SkinContacts
from dforc.errors import DforcError
from services.core.service import Inputs
from services.messages import Skin
from services.robotfile.robot_tables import RobotFile
from services.robotfile.shape_tables import skin_patches
from services.streams import SKIN
from services.wholebody.body import Body


class SkinWatch:
    """The skin boards whose place is known."""

    def __init__(self, robot: RobotFile, body: Body) -> None:
        patches = skin_patches(robot)
        frames = {sensor.frame: i for i, sensor in enumerate(body.sensors)}
        self.streams = tuple(SKIN[patch.board] for patch in patches)
        self.refused = 0
        self._boards = {SKIN[patch.board]: patch.board for patch in patches}
        self._heard: dict[str, Skin] = {}
        self._contacts = SkinContacts(patches)
        self._sensor_of = {
            patch.link: next(
                (frames[j] for j in body.tree.joints_above(patch.link) if j in frames), -1
            )
            for patch in patches
        }
        self._pressed: dict[int, SkinContact] = {}

    def look(self, now_ns: int, inputs: Inputs) -> None:
        """Take in what the boards said last."""
        for stream, board in self._boards.items():
            skin = inputs.latest(stream)
            if skin is not None and skin is not self._heard.get(board):
                self._heard[board] = skin
                heard_ns = now_ns - round(inputs.age_s(stream) * 1e9)
                try:
                    self._contacts.hear(board, skin.taxels, skin.errors, skin.no_load, heard_ns)
                except DforcError:
                    self.refused += 1
        self._pressed = {}
        for contact in self._contacts.contacts(now_ns):
            sensor = self._sensor_of[contact.link]
            strongest = self._pressed.get(sensor)
            if strongest is None or contact.pressure > strongest.pressure:
                self._pressed[sensor] = contact

    def pressed(self, sensor: int) -> SkinContact | None:
        """The strongest touch of the limb between a sensor and the next ones."""
        return self._pressed.get(sensor)
