"""Improv's nodes in ROS 2, their publishers, and their names (rclpy, imported lazily)."""

from __future__ import annotations

import os
import re
import socket
import sys
import threading
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

DEPTH = 10
"""QoS history depth. It is reliable, like teleop_twist_keyboard and Nav2, so all listeners match."""
STANDBY = "_standby"
"""The suffix of the names of nodes that publish only after their stage has died."""
READER = "_reader"
"""The suffix of the names of nodes that read sensors."""
PUBLISHER = "_publisher"
"""The suffix of the names of nodes that publish the forecast."""
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
"""The variable that names the settings of Fast DDS 2. Fast DDS 3 has another one, and other settings."""
OURS = Path(__file__).with_name("fast_dds.xml")
"""The settings with which nodes find each other soon."""
TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
"""The variable that selects the transports of Fast DDS.

With shared memory, Fast DDS publishes nothing for up to a third of a second when another node starts, because it checks
that memory first (eProsima/Fast-DDS issue 6535). So our nodes use UDP. If discovery is limited to this machine, ROS 2
sets the transports itself.
"""
_IN = r"/(?:\w+/)*"
"""The namespace before a node's name."""


class Nodes:
    """One node that lives as long as its process, and a second one if a topic needs both message types.

    `arguments` are ROS's: `--ros-args …`, without a name for the node. Raises what rclpy raises if they are wrong.
    """

    def __init__(self, name: str, arguments: Sequence[str] = (), **options: Any) -> None:
        imported_later("numpy")  # messages import it for fields that nobody here uses: it takes 12 MB
        # The maker of such modules, without which they work, takes 7 MB and 30 ms.
        sys.modules.setdefault("rosidl_generator_py.generate_py_impl", None)  # type: ignore[arg-type]
        import rclpy

        self._arguments = arguments
        self.first = _node(rclpy.get_default_context(), name, arguments, **options)
        self._second: Any = None

    @property
    def names(self) -> list[str]:
        """The full names: `/improv_…`."""
        return [node.get_fully_qualified_name() for node in self._all]

    def advertise(self, kind: Any, topic: str, second: bool) -> tuple[Any, Callable[[], None]]:
        """Create a publisher of a type, on the second node if `second`; return the publisher and a function that
        destroys it."""
        try:
            from rclpy.event_handler import PublisherEventCallbacks
        except ImportError:  # Humble
            from rclpy.qos_event import PublisherEventCallbacks
        node = self._second_node() if second else self.first
        # The default callbacks would keep a destroyed publisher on the topic while the executor waits.
        none = PublisherEventCallbacks(use_default_callbacks=False)
        overrides = None
        if self._arguments:  # they may override QoS; only then, because each topic declares three parameters for it
            from rclpy.qos_overriding_options import QoSOverridingOptions

            overrides = QoSOverridingOptions.with_default_policies()
        publisher = node.create_publisher(kind, topic, DEPTH, event_callbacks=none, qos_overriding_options=overrides)
        return publisher, lambda: node.destroy_publisher(publisher)

    def close(self) -> None:
        """Destroy the nodes. Otherwise they would stay in the graph for about twenty seconds."""
        import rclpy

        for node in self._all:
            node.destroy_node()
            rclpy.try_shutdown(context=node.context)

    @property
    def _all(self) -> list[Any]:
        return [self.first, self._second] if self._second else [self.first]

    def _second_node(self) -> Any:
        """The node for a topic's second type: Fast DDS refuses two types on one topic within one context.

        It is created only when needed and used for nothing else: its discovery can take seconds.
        """
        if not self._second:
            import rclpy

            # No executor spins it, so it offers no services.
            name = f"{self.first.get_name()}_2"
            self._second = _node(rclpy.Context(), name, self._arguments, start_parameter_services=False)
        return self._second


def subscribe(node: Any, kind: Any, topic: str, take: Callable[[Any], None], qos: Any) -> Any:
    """Create a subscription without rclpy's default callbacks for events."""
    try:
        from rclpy.event_handler import SubscriptionEventCallbacks
    except ImportError:  # Humble
        from rclpy.qos_event import SubscriptionEventCallbacks
    # The default callbacks would log what our warnings say, and keep a subscription in use while the executor waits.
    none = SubscriptionEventCallbacks(use_default_callbacks=False)
    return node.create_subscription(kind, topic, take, qos, event_callbacks=none)


def is_published(node: Any, topic: str) -> bool:
    """Return whether a topic, as ROS's arguments remap it, has a publisher."""
    return bool(node.count_publishers(node.resolve_topic_name(topic)))


def unpublished(node: Any, topic: str, kind: str) -> str | None:
    """Return the reason why no message of a type comes on a topic; None if somebody publishes such messages."""
    kinds = {info.topic_type for info in node.get_publishers_info_by_topic(topic)}
    if not kinds:
        return f"nobody publishes on {topic}"
    return None if kind in kinds else f"{topic} carries {', '.join(sorted(kinds))}, not {kind}"


def is_latched(publisher: Any) -> bool:
    """Return whether a publisher keeps messages for later subscriptions: those that ask for that get them."""
    qos = publisher.qos_profile
    return (qos.reliability.name, qos.durability.name) == ("RELIABLE", "TRANSIENT_LOCAL")


def qualities_for(depth: int, latched: bool) -> list[Any]:
    """Return the QoS of subscriptions that get every message of a topic, the earlier ones first if some publishers are
    `latched`. The last one fits all publishers; to ask for more than one of them offers would be an error there."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    kept = QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return [*([kept] if latched else []), QoSProfile(depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)]


def node_name(process: int | str = "") -> str:
    """Return a node name that no other Improv process uses, on this machine or another."""
    return f"improv_{re.sub('[^A-Za-z0-9_]', '_', socket.gethostname())}_{process or os.getpid()}"


def without_name(arguments: Sequence[str]) -> tuple[str | None, list[str]]:
    """Return the name that ROS's arguments give to all nodes (`-r __node:=NAME`), if any, and the arguments without it.

    Improv has several nodes and derives the name of each from this one.
    """
    name, kept = None, list[str]()
    for word in arguments:
        if found := re.fullmatch(r"(?:[^:]+:)?__(?:node|name):=(\w+)", word):
            name = found[1]
            kept.pop()  # the `-r` before it
        else:
            kept.append(word)
    return name, kept


def is_harmless(node: str) -> bool:
    """Return whether a node publishes nothing: a standby, or a node of a stage on this machine that was killed.

    The graph still shows a killed node for about twenty seconds. A node without a known name counts as harmless until a
    later look.
    """
    if node.endswith("_NODE_NAME_UNKNOWN_") or re.fullmatch(f"{_IN}improv_\\w+{STANDBY}(?:_2)?", node):
        return True
    found = re.fullmatch(f"{_IN}{node_name(process='([0-9]+)')}(?:_2)?", node)
    if not found or os.name != "posix":
        return False
    try:
        os.kill(int(found[1]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        pass  # another user's process, still alive
    return False


def _node(context: Any, name: str, arguments: Sequence[str], **options: Any) -> Any:
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    os.environ.setdefault(PROFILES, str(OURS))
    os.environ.setdefault(TRANSPORTS, "UDPv4")
    # rclpy's own handlers would invalidate the context before the last zero is sent.
    # Without log files, which would keep robots from moving if they can't be written; /rosout has what we log.
    all_arguments = ["--ros-args", "--disable-external-lib-logs", *arguments]
    rclpy.init(args=all_arguments, context=context, signal_handler_options=SignalHandlerOptions.NO)
    return rclpy.create_node(name, context=context, **options)


def imported_later(name: str) -> None:
    """Make later imports of this module return a stand-in that loads it on first use. Nothing changes if the module is
    loaded already or doesn't exist."""
    if name not in sys.modules and (spec := find_spec(name)):
        later = _LazyModule(name)
        later.__spec__ = spec  # without it, `find_spec` would fail
        sys.modules[name] = later


class _LazyModule(ModuleType):
    """A stand-in for a module that isn't loaded yet. It keeps working after the module was loaded."""

    def __getattr__(self, name: str) -> Any:
        with _replacing:
            if sys.modules.get(self.__name__) is self:
                del sys.modules[self.__name__]
        return getattr(import_module(self.__name__), name)


_replacing = threading.Lock()
