"""Services and parameters of our node, with which ROS 2 controls a dance (messages imported lazily; node passed in).

Requests are handled like those of a page: the parent decides, and the stage obeys a stop or a pause at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from improv_core.protocol.commands import PageRequest, Pause, Stop
from improv_core.protocol.fields import FASTEST, SLOWEST
from improv_core.protocol.messages import FromStage
from improv_core.protocol.play_again import Heard, play

Ask = Callable[[PageRequest], None]
"""Passes on a request; may be called from any thread."""

_SPEED, _TEMPO = "speed", "tempo"


class Requests:
    """Offers `~/stop`, `~/play`, and `~/pause` (std_srvs/Trigger), and the parameters `speed` and `tempo`.

    The node's executor calls it back on its thread; `show` is called from the stage's.
    """

    def __init__(self, node: Any, ask: Ask) -> None:
        from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
        from std_srvs.srv import Trigger

        self._node = node
        self._ask = ask
        self._heard = Heard()
        self._values = {_TEMPO: 60.0, _SPEED: 1.0}
        limits = FloatingPointRange(from_value=SLOWEST, to_value=FASTEST)
        about_speed = ParameterDescriptor(description="times the tempo", floating_point_range=[limits])
        about_tempo = ParameterDescriptor(description="beats per minute, read-only: the program sets it")
        node.declare_parameter(_TEMPO, self._values[_TEMPO], about_tempo, ignore_override=True)
        self._asked_at_start: float | None = None
        if (speed := node.declare_parameter(_SPEED, self._values[_SPEED], about_speed).value) != self._values[_SPEED]:
            self._values[_SPEED] = self._asked_at_start = speed
            ask({"type": "speed", "factor": speed})
        node.add_on_set_parameters_callback(self._set)
        for name, answer in (("stop", self._stop), ("play", self._play), ("pause", self._pause)):
            node.create_service(Trigger, f"~/{name}", _answering(answer))

    def show(self, message: FromStage) -> None:
        self._heard = self._heard.after(message)
        if message["type"] != "transport":
            return
        if self._asked_at_start == message["speed"]:  # the parent received nothing before the stage was ready
            self._ask({"type": "speed", "factor": message["speed"]})
        self._asked_at_start = None
        now = {_TEMPO: float(message["tempo"]), _SPEED: float(message["speed"])}
        if changed := {name: value for name, value in now.items() if value != self._values[name]}:
            from rclpy.parameter import Parameter

            self._values.update(changed)
            self._node.set_parameters([Parameter(name, value=value) for name, value in changed.items()])

    def _set(self, parameters: Sequence[Any]) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        for parameter in parameters:
            if parameter.name == _TEMPO and parameter.value != self._values[_TEMPO]:
                return SetParametersResult(
                    successful=False, reason="tempo is read-only: set speed, or change `beat` in the program"
                )
        for parameter in parameters:
            if parameter.name == _SPEED and parameter.value != self._values[_SPEED]:
                self._values[_SPEED] = parameter.value
                self._ask({"type": "speed", "factor": parameter.value})
        return SetParametersResult(successful=True)

    def _stop(self) -> tuple[bool, str]:
        self._ask(Stop(type="stop", by="ros"))
        return True, "all robots are being stopped"

    def _pause(self) -> tuple[bool, str]:
        if self._heard.state not in ("playing", "waiting"):
            return False, "nothing plays"
        self._ask(Pause(type="pause"))
        return True, "pausing"

    def _play(self) -> tuple[bool, str]:
        reply = play(self._heard, "ros")
        if reply.request:
            self._ask(reply.request)
        return reply.succeeds, reply.line


def _answering(answer: Callable[[], tuple[bool, str]]) -> Callable[[Any, Any], Any]:
    def respond(_: Any, response: Any) -> Any:
        response.success, response.message = answer()
        return response

    return respond
