"""The nodes by which Improv publishes to ROS 2, and their names (rclpy, imported lazily)."""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Callable
from typing import Any

DEPTH = 10
"""Messages kept for a slow listener, reliably: as teleop_twist_keyboard and Nav2 publish, so all listeners match."""
STANDBY = "_standby"
"""How the names of nodes end that send only after their stage has died."""


class Nodes:
    """One node that lives as long as its process, and a second one where a topic needs both types of message."""

    def __init__(self, name: str, **options: bool) -> None:
        import rclpy

        self.first = _node(rclpy.get_default_context(), name, **options)
        self._second: Any = None

    @property
    def names(self) -> list[str]:
        """Full names: `/improv_…`."""
        return [node.get_fully_qualified_name() for node in self._all]

    def advertise(self, kind: Any, topic: str, second: bool) -> tuple[Any, Callable[[], None]]:
        """A publisher of a type of message, on the second node if asked to, and what destroys it."""
        try:
            from rclpy.event_handler import PublisherEventCallbacks
        except ImportError:  # Humble
            from rclpy.qos_event import PublisherEventCallbacks
        node = self._second_node() if second else self.first
        # The default callbacks keep a publisher in use while the executor waits, and its type on the topic too.
        none = PublisherEventCallbacks(use_default_callbacks=False)
        publisher = node.create_publisher(kind, topic, DEPTH, event_callbacks=none)
        return publisher, lambda: node.destroy_publisher(publisher)

    def close(self) -> None:
        """Say goodbye: a node that does not stays in everybody's graph for some twenty seconds."""
        import rclpy

        for node in self._all:
            node.destroy_node()
            rclpy.try_shutdown(context=node.context)

    @property
    def _all(self) -> list[Any]:
        return [self.first, self._second] if self._second else [self.first]

    def _second_node(self) -> Any:
        """Fast DDS refuses two types on one topic within one context.

        Made when it is needed, and used for nothing else: its discovery takes up to seconds.
        """
        if not self._second:
            import rclpy

            # Nobody spins it, so it offers no services.
            name = f"{self.first.get_name()}_2"
            self._second = _node(rclpy.Context(), name, start_parameter_services=False)
        return self._second


def node_name(process: int | str = "") -> str:
    """A name that no other Improv on this machine or another one has."""
    return f"improv_{re.sub('[^A-Za-z0-9_]', '_', socket.gethostname())}_{process or os.getpid()}"


def is_harmless(node: str) -> bool:
    """Whether a node named by the graph sends nothing: a standby, or one of a stage here that was killed.

    The graph shows a killed one for some twenty seconds more. A node whose name it does not know yet is left to a
    later look.
    """
    if node.endswith("_NODE_NAME_UNKNOWN_") or re.fullmatch(f"/improv_\\w+{STANDBY}(?:_2)?", node):
        return True
    found = re.fullmatch(f"/{node_name(process='([0-9]+)')}(?:_2)?", node)
    if not found or os.name != "posix":
        return False
    try:
        os.kill(int(found[1]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        pass  # somebody else's, and alive
    return False


def _node(context: Any, name: str, **options: bool) -> Any:
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    # rclpy's own handlers would invalidate the context before the last zero could be sent.
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    return rclpy.create_node(name, context=context, **options)
