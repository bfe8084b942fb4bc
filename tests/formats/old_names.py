"""What messages of the studio of 0.1 and 0.2 call that is called otherwise since: the one table that reads them."""

from __future__ import annotations

import json
from typing import Any

REQUESTS = {
    "advise": "request_advice",
    "agent": "select_agent",
    "ask_when": "set_query_policy",
    "changes": "diff_versions",
    "choose": "change_design",
    "goal": "choose_goal",
    "hand_over": "release_control",
    "here": "heartbeat",
    "mend": "correct_slip",
    "others": "set_other_agents",
    "place": "move_robot",
    "promise": "add_property",
    "score": "toggle_score",
    "stand_by": "confirm_press",
    "stand_for": "bind_targets",
    "take": "take_control",
    "turn": "toggle_mode",
    "use_reaction": "set_reaction_time",
    "versions": "list_versions",
    "visit": "go_to_property",
    "watch": "toggle_watching",
    "withdraw": "remove_property",
}
"""What a page asks, in its field `do`."""
REQUEST_FIELDS = {"outcome": "property", "when": "policy"}
FIELDS = {
    ("", "desk"): "session",
    ("", "directed"): "is_controlled",
    ("", "can_take"): "can_take_control",
    ("", "directs"): "has_control",
    ("", "late"): "reaction",
    ("", "said"): "message",
    ("", "said_number"): "message_number",
    ("", "simpler"): "preview",
    ("", "tested"): "test",
    ("", "worse"): "regressions",
    ("advice", "place"): "can_set_up",
    ("advice", "says"): "slip",
    ("agents", "doing"): "states",
    ("asking", "when"): "policy",
    ("desk", "asking"): "queries",
    ("desk", "doing"): "activities",
    ("desk", "outcomes"): "properties",
    ("desk", "taught"): "presses",
    ("desk", "waiting"): "pending",
    ("evaluation", "called"): "behavior",
    ("evaluation", "through"): "finished",
    ("failures", "leads_to"): "previous_world",
    ("failures", "through"): "finished",
    ("findings", "place"): "can_set_up",
    ("last", "here"): "in_lesson",
    ("last", "more"): "omitted",
    ("last", "read"): "readings",
    ("last", "says"): "decision",
    ("levels", "here"): "in_lesson",
    ("levels", "more"): "omitted",
    ("levels", "read"): "readings",
    ("levels", "says"): "decision",
    ("levels", "yours"): "in_training",
    ("library", "cut_off"): "interrupted",
    ("outcomes", "said"): "description",
    ("places", "saves"): "can_save",
    ("properties", "through"): "finished",
    ("scene", "eyes"): "camera_robots",
    ("scene", "holds"): "needs_held_key",
    ("scene", "real"): "real_robots",
    ("simpler", "enough"): "examples_needed",
    ("tested", "else"): "differences",
    ("tested", "outcomes"): "properties",
    ("tested", "worse"): "regressions",
    ("trained", "why_not"): "problem",
}
"""What the studio says: a field by the one that it stands in, both as they were; that of a whole message is empty."""


def rename_request(text: str) -> str:
    """Return what a page asked with the names of today; what is no JSON object with a known name stays."""
    try:
        request = json.loads(text)
    except ValueError:
        return text
    if not isinstance(request, dict) or request.get("do") not in REQUESTS:
        return text
    return json.dumps(
        {
            REQUEST_FIELDS.get(key, key): REQUESTS[each] if key == "do" else each
            for key, each in request.items()
        }
    )


def rename_message(message: Any, within: str = "") -> Any:
    """Return what the studio said with the names of today."""
    match message:
        case dict():
            renamed = {
                FIELDS.get((within, key), key): rename_message(each, key) for key, each in message.items()
            }
            return renamed | {"is": "session"} if within == "" and message.get("is") == "desk" else renamed
        case list():
            return [rename_message(each, within) for each in message]
        case _:
            return message


def rename_exchange(exchange: dict[str, Any]) -> dict[str, Any]:
    """Return a line of a transcript, what was asked and what was answered, with the names of today."""
    asked = exchange["say"]
    return {
        "say": asked if asked is None else rename_request(asked),
        "hear": [rename_message(each) for each in exchange["hear"]],
    }
