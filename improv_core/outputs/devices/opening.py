"""Opens an output of the group `improv.outputs`, by its name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.metadata import entry_points

from improv_core.ipc.arrivals import OutputChannel
from improv_core.outputs.devices.device import Device
from improv_core.outputs.devices.sink import DeviceSink
from improv_core.protocol.output import Sink
from improv_core.score.installed import GROUP


def prepare(arguments: Sequence[str]) -> Callable[[OutputChannel], Sink]:
    """Return a function that opens the output whose name is the argument. It raises ImportError if there is none."""
    (name,) = arguments
    return lambda channel: DeviceSink(name, device_class(name), channel.hear, channel.warn)


def device_class(name: str) -> type[Device]:
    """Return the class that moves robots of this output. Raises ImportError."""
    for each in entry_points(group=GROUP, name=name):
        found = each.load()
        if isinstance(found, type) and issubclass(found, Device):
            return found
        raise ImportError(f"the output {name} is no subclass of improv_core.outputs.devices.device.Device")
    raise ImportError(f"no output {name} is installed")
