"""What a page may say: one JSON object per message, checked down to the field before anything happens."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, TypeAlias, Union

import msgspec
from msgspec import Meta, Struct, field

from understudy.errors import UnderstudyError
from understudy.ui.web.messages import coach, review
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
"""How long a message may be."""


SpeedFactor: TypeAlias = float | Literal["fastest"]
"""How many times as fast as in life, or as fast as it goes."""


class PressState(Message, frozen=True, kw_only=True, tag="press"):
    """Direct to a state; a correction in testing."""

    state: Call


class Confirm(Message, frozen=True, kw_only=True, tag="confirm"):
    """Keep doing this."""


class ToggleMode(Message, frozen=True, kw_only=True, tag="turn"):
    """From training to testing, or back."""


class Undo(Message, frozen=True, kw_only=True, tag="undo"):
    """Take back the last step that changed the lesson."""


class Redo(Message, frozen=True, kw_only=True, tag="redo"):
    """Do the last undone step again."""


class Pause(Message, frozen=True, kw_only=True, tag="pause"):
    """Let time stand still, or go on."""

    paused: bool


class StepTick(Message, frozen=True, kw_only=True, tag="step"):
    """One tick, then pause."""


class SetSpeed(Message, frozen=True, kw_only=True, tag="speed"):
    """How many times as fast as in life, or as fast as it goes."""

    speed: SpeedFactor


class ResetWorld(Message, frozen=True, kw_only=True, tag="reset"):
    """The world of a seed from its beginning; the same seed again where none is given."""

    seed: Seed | None = None


class RestartAutomaton(Message, frozen=True, kw_only=True, tag="restart"):
    """The automaton afresh, the robot where it is."""


class Rewind(Message, frozen=True, kw_only=True, tag="rewind"):
    """Go back to a moment of the run: a time of the world (s), or when an example was shown."""

    time_s: float | None = None
    example: Index | None = None


class BindTargets(Message, frozen=True, kw_only=True, tag="stand_for"):
    """Let parameters stand for other targets."""

    targets: Targets


class OpenAutomaton(Message, frozen=True, kw_only=True, tag="open"):
    """Train an automaton of the library on."""

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
    discard: bool = False


class ChangeDesign(Message, frozen=True, kw_only=True, tag="choose"):
    """Choose anew what the lesson is about; examples stay where they can, also those of states `renamed`."""

    states: Calls
    features: Calls
    flags: NameListField = field(default_factory=list)
    renamed: dict[Call, Call] = field(default_factory=dict)
    watched: bool | None = None
    reaction_s: float | None = None
    unlearning: bool | None = None


class DeleteExample(Message, frozen=True, kw_only=True, tag="delete"):
    """Delete an example."""

    number: Index


class QuarantineExamples(Message, frozen=True, kw_only=True, tag="quarantine"):
    """Let examples teach nothing for now."""

    numbers: Annotated[list[Index], Meta(min_length=1, max_length=200)]


class ReleaseExamples(Message, frozen=True, kw_only=True, tag="release"):
    """Let examples teach again."""

    numbers: Annotated[list[Index], Meta(min_length=1, max_length=200)]


class EditExample(Message, frozen=True, kw_only=True, tag="edit"):
    """Let an example say another state, next state, or values, which are written as they are shown."""

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
    """Throw away a lesson that was cut off."""

    name: NameField


class RecallSession(Message, frozen=True, kw_only=True, tag="recall"):
    """Offer a lesson again that was cut off and thrown away."""

    name: NameField


class RenameBehavior(Message, frozen=True, kw_only=True, tag="rename"):
    """Give a trained behavior another name."""

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


class SelectAgent(Message, frozen=True, kw_only=True, tag="agent"):
    """Which robot is trained, or which squad's coordinator: that of a squad of this sort."""

    agent: Index
    sort: NameField | None = None
    discard: bool = False


class SetOtherAgents(Message, frozen=True, kw_only=True, tag="others"):
    """What the robots do meanwhile that are not trained: idle, or a behavior of the library."""

    behavior: NameField | None
    targets: Targets = field(default_factory=dict)


class ToggleWatching(Message, frozen=True, kw_only=True, tag="watch"):
    """I am not watching, so that silence is no consent; or I am again."""


class MoveRobot(Message, frozen=True, kw_only=True, tag="place"):
    """Put a robot elsewhere; without a heading it keeps its own."""

    agent: Index
    x: float
    y: float
    heading: float | None = None


class MoveObject(Message, frozen=True, kw_only=True, tag="move_object"):
    """Put an object elsewhere."""

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
    """Put a round obstacle elsewhere; it is counted as in the scene."""

    index: Index
    x: float
    y: float


class RemoveObstacle(Message, frozen=True, kw_only=True, tag="remove_obstacle"):
    """Remove a round obstacle."""

    index: Index


class TakeControl(Message, frozen=True, kw_only=True, tag="take"):
    """Become director where nobody is, or where the present one has been silent for long."""


class Arm(Message, frozen=True, kw_only=True, tag="arm"):
    """Let real robots move from now on."""


class EmergencyStop(Message, frozen=True, kw_only=True, tag="stop"):
    """Stop real robots at once: the emergency stop of every page."""

    by_anyone: ClassVar[bool] = True


class Heartbeat(Message, frozen=True, kw_only=True, tag="here"):
    """The page is there still, and the person holds the key that real robots may move by, or does not."""

    holding: bool = False


class PickColor(Message, frozen=True, kw_only=True, tag="pick_color"):
    """Clicks (column, row) into an image of a robot's camera: that is the color of what is called so."""

    robot: Index
    name: NameField
    image: Annotated[int, Meta(ge=1)]
    points: Annotated[list[tuple[Index, Index]], Meta(min_length=1, max_length=200)]


class ReleaseControl(Message, frozen=True, kw_only=True, tag="hand_over"):
    """No longer direct: anyone may take."""


_MODULES = (__name__, review.__name__, coach.__name__)
REQUESTS: tuple[type[Message], ...] = tuple(
    each for each in Message.__subclasses__() if each.__module__ in _MODULES
)
"""All that a page may send."""


class InvalidMessage(UnderstudyError, json_type="UnusableMessage"):
    """A message that is not one of those a page may send."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        super().__init__(f"the message cannot be used, and changed nothing: {problem}")


class InvalidField(InvalidMessage, json_type="UnusableField"):
    """A message with something that a person typed and that cannot be used."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        UnderstudyError.__init__(self, f"{problem[0].upper()}{problem[1:]}. Nothing was changed")


class _Numbered(Struct):
    id: Id | None = None


_messages: msgspec.json.Decoder[Message] = msgspec.json.Decoder(Union[REQUESTS])  # noqa: UP007 - they are found, not listed
_number = msgspec.json.Decoder(_Numbered).decode


def parse_message(text: str | bytes) -> Message:
    """The message a page sent; UnusableMessage where it is none."""
    if len(text) > MOST_BYTES or (isinstance(text, str) and len(text.encode(errors="replace")) > MOST_BYTES):
        raise InvalidMessage(problem=f"it is longer than {MOST_BYTES} bytes")
    try:
        return _messages.decode(text)
    except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
        typed = describe_schema_error(str(error))
        raise InvalidField(problem=typed) if typed else InvalidMessage(problem=str(error)) from error


def find_message_number(text: str | bytes) -> int | None:
    """The number of a message that could not be read, so that its answer can say which it was."""
    if len(text) > MOST_BYTES:
        return None
    try:
        return _number(text).id
    except (msgspec.MsgspecError, UnicodeError, RecursionError):
        return None
