"""A process that sends every ping back, answers orders, and says farewell when it is closed."""

import signal

from services.core.live import Context, run_process
from services.core.service import Inputs, Outputs, Service
from tests.live.toy_streams import FAREWELL, ORDER, PING, PONG, SETTING, Done, Ping


class Echo(Service):
    reads = (PING, SETTING)
    writes = (PONG, FAREWELL)
    serves = (ORDER,)
    trigger = PING

    def __init__(self) -> None:
        self._echoed = 0

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        for ping in inputs.all_new(PING):
            self._echoed += 1
            outputs.put(PONG, ping)
        for token, order in inputs.requests(ORDER):
            if order.action == "fail":
                raise ValueError("told to fail")
            if order.action == "deaf":
                signal.signal(signal.SIGTERM, signal.SIG_IGN)
            if order.action != "ignore":
                setting = inputs.latest(SETTING)
                number = -1 if setting is None else setting.number
                outputs.reply(ORDER, token, Done(f"{order.action}, setting {number}"))

    def close(self, now_ns: int, outputs: Outputs) -> None:
        outputs.put(FAREWELL, Ping(now_ns, self._echoed))


def build(context: Context) -> Echo:
    context.open_bus(2)  # never read: for the test of a frozen consumer
    return Echo()


if __name__ == "__main__":
    raise SystemExit(run_process("echo", build))
