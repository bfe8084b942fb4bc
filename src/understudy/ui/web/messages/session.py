"""The requests of the page: one JSON object per message, validated completely before it is executed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, TypeAlias, Union

import msgspec
from msgspec import Meta, Struct, field

from understudy.errors import UnderstudyError
from understudy.ui.web.messages import review
from understudy.ui.web.messages.base import (
    Call,
    Calls,
    Id,
    Index,
    Message,
    NameField,
    NameListField,
    Seed,
    Targets,
    ValueField,
    describe_schema_error,
)

MOST_BYTES = 64 * 1024
"""The greatest length of a message, in bytes."""


SpeedFactor: TypeAlias = float | Literal["fastest"]
"""A simulation speed: a multiple of real time, or as fast as possible."""


class PressState(Message, frozen=True, kw_only=True, tag="press"):
    """Direct the robot to a state; in testing this is a correction."""

    state: Call


class Confirm(Message, frozen=True, kw_only=True, tag="confirm"):
    """Confirm the current state."""


class ToggleMode(Message, frozen=True, kw_only=True, tag="toggle_mode"):
    """Switch between training and testing."""


class Undo(Message, frozen=True, kw_only=True, tag="undo"):
    """Undo the last step that changed the lesson."""


class Redo(Message, frozen=True, kw_only=True, tag="redo"):
    """Redo the last undone step."""


class Pause(Message, frozen=True, kw_only=True, tag="pause"):
    """Pause or resume."""

    paused: bool


class StepTick(Message, frozen=True, kw_only=True, tag="step"):
    """Run one tick, then pause."""


class SkipAhead(Message, frozen=True, kw_only=True, tag="skip"):
    """Skip to the next moment at which the person is needed, and pause there."""


class SetSpeed(Message, frozen=True, kw_only=True, tag="speed"):
    """Set the speed: a multiple of real time, or as fast as possible."""

    speed: SpeedFactor


class ResetWorld(Message, frozen=True, kw_only=True, tag="reset"):
    """Reset the world to a seed; to the same seed if none is given."""

    seed: Seed | None = None


class RestartAutomaton(Message, frozen=True, kw_only=True, tag="restart"):
    """Restart the automaton and leave the robot where it is."""


class Rewind(Message, frozen=True, kw_only=True, tag="rewind"):
    """Go back to a moment of the run: a time of the world (s), or just before an example was given."""

    time_s: float | None = None
    example: Index | None = None


class BindTargets(Message, frozen=True, kw_only=True, tag="bind_targets"):
    """Bind parameters to other targets."""

    targets: Targets


class OpenAutomaton(Message, frozen=True, kw_only=True, tag="open"):
    """Continue the training of an automaton of the library."""

    name: NameField
    discard: bool = False


class NewAutomaton(Message, frozen=True, kw_only=True, tag="new"):
    """Begin a new automaton."""

    name: NameField
    states: Calls
    features: Calls
    parameters: NameListField = field(default_factory=list)
    flags: NameListField = field(default_factory=list)
    targets: Targets = field(default_factory=dict)
    watched: bool | None = None
    reaction_s: float | None = None
    unlearning: bool | None = None
    live: bool | None = None
    discard: bool = False


class ChangeDesign(Message, frozen=True, kw_only=True, tag="change_design"):
    """Change states, features or options of the lesson.

    Examples that still apply are kept, also those of states in `renamed` (former name to new name).
    """

    states: Calls
    features: Calls
    flags: NameListField = field(default_factory=list)
    renamed: dict[Call, Call] = field(default_factory=dict)
    watched: bool | None = None
    reaction_s: float | None = None
    unlearning: bool | None = None
    live: bool | None = None


class DeleteExample(Message, frozen=True, kw_only=True, tag="delete"):
    """Delete an example."""

    number: Index


class QuarantineExamples(Message, frozen=True, kw_only=True, tag="quarantine"):
    """Put examples into quarantine: the learner ignores them."""

    numbers: Annotated[list[Index], Meta(min_length=1, max_length=200)]


class ReleaseExamples(Message, frozen=True, kw_only=True, tag="release"):
    """Release examples from quarantine."""

    numbers: Annotated[list[Index], Meta(min_length=1, max_length=200)]


class EditExample(Message, frozen=True, kw_only=True, tag="edit"):
    """Change an example's state, next state, or values; values are written as the page shows them."""

    number: Index
    state: Call | None = None
    next: Call | None = None
    values: dict[Call, ValueField] = field(default_factory=dict)


class TrashBehavior(Message, frozen=True, kw_only=True, tag="remove"):
    """Move a trained behavior to the trash."""

    name: NameField


class RestoreBehavior(Message, frozen=True, kw_only=True, tag="restore"):
    """Bring a trained behavior back from the trash."""

    name: NameField


class DiscardSession(Message, frozen=True, kw_only=True, tag="discard"):
    """Discard an interrupted session."""

    name: NameField


class RecallSession(Message, frozen=True, kw_only=True, tag="recall"):
    """Recall an interrupted session that was discarded."""

    name: NameField


class RenameBehavior(Message, frozen=True, kw_only=True, tag="rename"):
    """Rename a trained behavior."""

    name: NameField
    to: NameField


class DuplicateBehavior(Message, frozen=True, kw_only=True, tag="duplicate"):
    """Copy a trained behavior as it is in the library."""

    name: NameField
    to: NameField


class RevertVersion(Message, frozen=True, kw_only=True, tag="go_back"):
    """Make a former version of a trained behavior the present one again."""

    name: NameField
    version: Index


class SelectAgent(Message, frozen=True, kw_only=True, tag="select_agent"):
    """Select the robot to train, or the coordinator of a squad of this sort."""

    agent: Index
    sort: NameField | None = None
    discard: bool = False


class OpenWorld(Message, frozen=True, kw_only=True, tag="open_world"):
    """Go to a world of another scenario, one of those that the studio lists."""

    name: NameField
    discard: bool = False


class OpenLibrary(Message, frozen=True, kw_only=True, tag="open_library"):
    """Use another library, one of those that the studio lists, or a new one of this name."""

    name: NameField
    discard: bool = False


class SaveWorld(Message, frozen=True, kw_only=True, tag="save_world"):
    """Save the world as it stands as a scenario of this name."""

    name: NameField


class SetOtherAgents(Message, frozen=True, kw_only=True, tag="set_other_agents"):
    """Set what the robots that are not in training do: idle, or a behavior of the library."""

    behavior: NameField | None
    targets: Targets = field(default_factory=dict)


class ToggleWatching(Message, frozen=True, kw_only=True, tag="toggle_watching"):
    """Turn learning from silence off or on."""


class KeepGoing(Message, frozen=True, kw_only=True, tag="keep_going"):
    """Test what is in training in new worlds, and go to where it goes wrong."""


class GoBackToBest(Message, frozen=True, kw_only=True, tag="go_back_to_best"):
    """Undo what was done since the best version that was tested, and go to where that one goes wrong."""


class ChooseGoal(Message, frozen=True, kw_only=True, tag="choose_goal"):
    """Choose what success means, by the name of an offered goal; null: nothing is chosen."""

    goal: NameField | None


class ToggleScore(Message, frozen=True, kw_only=True, tag="toggle_score"):
    """Turn the runs in new worlds after each press off or on."""


class MoveRobot(Message, frozen=True, kw_only=True, tag="move_robot"):
    """Move a robot; without a heading it keeps its own."""

    agent: Index
    x: float
    y: float
    heading: float | None = None


class MoveObject(Message, frozen=True, kw_only=True, tag="move_object"):
    """Move an object."""

    slot: Index
    x: float
    y: float


class AddObject(Message, frozen=True, kw_only=True, tag="add_object"):
    """Add an object of a class."""

    kind: NameField
    x: float
    y: float


class RemoveObject(Message, frozen=True, kw_only=True, tag="remove_object"):
    """Remove an object."""

    slot: Index


class AddObstacle(Message, frozen=True, kw_only=True, tag="add_obstacle"):
    """Add a round obstacle."""

    x: float
    y: float
    radius: float


class MoveObstacle(Message, frozen=True, kw_only=True, tag="move_obstacle"):
    """Move a round obstacle, given by its position in the scene."""

    index: Index
    x: float
    y: float


class RemoveObstacle(Message, frozen=True, kw_only=True, tag="remove_obstacle"):
    """Remove a round obstacle."""

    index: Index


class TakeControl(Message, frozen=True, kw_only=True, tag="take_control"):
    """Take control if no client has it, or if the one that has it has been silent for long."""


class Arm(Message, frozen=True, kw_only=True, tag="arm"):
    """Arm the real robots."""


class ArmRobot(Message, frozen=True, kw_only=True, tag="arm_robot"):
    """Arm one real robot."""

    name: NameField


class StopRobot(Message, frozen=True, kw_only=True, tag="stop_robot"):
    """Stop one real robot at once, from any page."""

    name: NameField
    by_anyone: ClassVar[bool] = True


class EmergencyStop(Message, frozen=True, kw_only=True, tag="stop"):
    """Stop real robots at once: the emergency stop of every page."""

    by_anyone: ClassVar[bool] = True


class Heartbeat(Message, frozen=True, kw_only=True, tag="heartbeat"):
    """Report that the page is alive, and whether the key that lets real robots move is held down."""

    holding: bool = False


class PickColor(Message, frozen=True, kw_only=True, tag="pick_color"):
    """Learn a named color from clicks (column, row) into an image of a robot's camera."""

    robot: Index
    name: NameField
    image: Annotated[int, Meta(ge=1)]
    points: Annotated[list[tuple[Index, Index]], Meta(min_length=1, max_length=200)]


class ReleaseControl(Message, frozen=True, kw_only=True, tag="release_control"):
    """Release control."""


_MODULES = (__name__, review.__name__)
REQUESTS: tuple[type[Message], ...] = tuple(
    each for each in Message.__subclasses__() if each.__module__ in _MODULES
)
"""The types of all requests."""


class InvalidMessage(UnderstudyError, json_type="UnusableMessage"):
    """A message that is not a valid request."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        super().__init__(f"the message cannot be used, and changed nothing: {problem}")


class InvalidField(InvalidMessage, json_type="UnusableField"):
    """A request with an invalid value that a person typed."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        UnderstudyError.__init__(self, f"{problem[0].upper()}{problem[1:]}. Nothing was changed")


class _Numbered(Struct):
    id: Id | None = None


_messages: msgspec.json.Decoder[Message] = msgspec.json.Decoder(Union[REQUESTS])  # noqa: UP007 - they are found, not listed
_number = msgspec.json.Decoder(_Numbered).decode


def parse_message(text: str | bytes) -> Message:
    """Return the request in a message; raise InvalidMessage if it is not valid."""
    if len(text) > MOST_BYTES or (isinstance(text, str) and len(text.encode(errors="replace")) > MOST_BYTES):
        raise InvalidMessage(problem=f"it is longer than {MOST_BYTES} bytes")
    try:
        return _messages.decode(text)
    except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
        typed = describe_schema_error(str(error))
        raise InvalidField(problem=typed) if typed else InvalidMessage(problem=str(error)) from error


def find_message_number(text: str | bytes) -> int | None:
    """Return the number of an invalid message for its answer; None if it has no readable number."""
    if len(text) > MOST_BYTES:
        return None
    try:
        return _number(text).id
    except (msgspec.MsgspecError, UnicodeError, RecursionError):
        return None
