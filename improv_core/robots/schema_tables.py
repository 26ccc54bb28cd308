"""Tables made from the schema: those in docs/robots.md and docs/ros.md, and the JSON schema."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from improv_core.robots.schema import SCHEMA
from improv_core.robots.schema_key import Key


def rows(keys: Mapping[str, Key]) -> list[str]:
    """Format the keys of a table as lines of a Markdown table, without columns that would be empty."""
    cells = [[f"`{name}`", key.about, key.unit, key.range, key.default] for name, key in keys.items()]
    heads = ["key", "what it sets", "unit", "min, max", "default"]
    used = [column for column in range(len(heads)) if any(row[column] for row in cells)]
    lines = [[heads[column] for column in used], *([row[column] for column in used] for row in cells)]
    made = [f"| {' | '.join(line)} |".replace("  ", " ") for line in lines]
    return [made[0], "|" + "---|" * len(used), *made[1:]]


def json_schema() -> Mapping[str, Any]:
    """Convert the table to a JSON schema, for TOML tools such as Taplo."""
    return {"$schema": "http://json-schema.org/draft-07/schema#", "title": "improv.toml", **_json(SCHEMA)}


def _json(key: Key) -> dict[str, Any]:
    about = f"{key.about}; in {key.unit}" if key.unit else key.about
    made: dict[str, Any] = {"type": key.type, "description": about}
    if key.choices:
        made["enum"] = list(key.choices)
    if key.least < key.most and key.type != "array":
        made |= {"minimum": key.least, "maximum": key.most}
        if key.least > 0 and key.unit == "seconds":  # 0 means something else there
            made["minimum"] = 0
    if key.type == "object":
        made["properties"] = {name: _json(inner) for name, inner in key.keys.items()}
        made["additionalProperties"] = _json(key.named) if key.named else False
    if key.required:
        made["required"] = list(key.required)
    if key.items:
        made["items"] = _json(key.items)
    if key.count:
        made |= {"minItems": key.count, "maxItems": key.count}
    return made
