"""Find poses that no body part can reach."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.diagnostics import Diagnostic
from improv_core.program.reader import Reader
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node


def misplaced_poses(body: Node, reader: Reader) -> Iterator[Diagnostic]:
    """Report the poses, and the uses of names with poses, that no word for a body part contains. `reader` read them."""
    if isinstance(body, nodes.PoseTerm):
        pose = f"{body.word.text} {body.pose.text}"
        yield _misplaced(body, f"only body parts reach poses: write one before `{pose}`, such as `head {pose}`")
    elif isinstance(body, nodes.Name | nodes.Call):
        if poses := reader.movement_made(body).body_words.loose_poses:
            arguments = body.movements if isinstance(body, nodes.Call) else ()
            found = [each for argument in arguments for each in misplaced_poses(argument, reader)]
            name = nodes.use_name(body)
            message = f"`{name.text}` reaches the pose `{poses[0]}`: write a body part before it"
            yield from found or [_misplaced(name, message)]
    elif not isinstance(body, nodes.PartTerm):
        for child in nodes.children(body):
            yield from misplaced_poses(child, reader)


def _misplaced(node: Node, message: str) -> Diagnostic:
    return Diagnostic("misplaced-pose", node.span, message)
