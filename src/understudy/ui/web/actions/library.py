"""Handle messages about the library: save, trash, restore, rename, duplicate, list and compare versions."""

from __future__ import annotations

from msgspec import field

from understudy.errors import SessionError, UnknownName
from understudy.learning.change_attribution import (
    ExampleAttribution,
    HowMoved,
    attribute_condition_changes,
)
from understudy.learning.fit import learn
from understudy.model.diff import diff_automata
from understudy.model.library import TrainedAutomaton
from understudy.storage import library_folder
from understudy.storage.library_folder import list_versions, load_version, normalize_name, save_automaton
from understudy.ui.controller import interrupted_sessions
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.actions import session
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.review import DiffVersions, ListVersions, SaveAutomaton
from understudy.ui.web.messages.session import (
    DiscardSession,
    DuplicateBehavior,
    RecallSession,
    RenameBehavior,
    RestoreBehavior,
    RevertVersion,
    TrashBehavior,
)
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views import lesson_test, library
from understudy.ui.web.views.session import ChangeSummaryData, describe_change


class NotSavedReply(Data, frozen=True, kw_only=True):
    """Why the automaton was not saved: what worked and no longer does, and what it decides otherwise."""

    regressions: list[str]
    changed: ChangeSummaryData | None
    """What changed since it was last saved, apart from what presses since then say."""


def save_current_automaton(host: SessionHost, message: SaveAutomaton) -> NotSavedReply | StatusMessage:
    """Save the automaton in training, or a copy of it under another name.

    If something that worked no longer does, or it decides otherwise than the saved one beyond what was pressed since,
    return that instead, unless `anyway` is set.
    """
    trainer, name = host.active_trainer, message.name
    if name is None or name == trainer.name:
        host.refresh_library()
        worse = () if message.anyway else lesson_test.find_unsaved_regressions(host)
        changed = None if message.anyway else trainer.change_to_save
        if worse or changed is not None:
            why = "something that worked no longer does" if worse else str(changed)
            trainer.status = StatusMessage(f"{trainer.name} is not saved yet: {why}")
            return NotSavedReply(regressions=list(worse), changed=describe_change(changed))
        trainer.save_unchecked(trainer.session.make_trained_automaton())
        status = StatusMessage(f"{trainer.name} is saved", "recorded")
    else:
        host.refresh_library()
        host.library_view.refuse_new(name, remedy="give another name")
        library.save_copy(host.library_view, trainer.session.make_trained_automaton(), name)
        status = StatusMessage(f"A copy of {trainer.name} is saved as {name}", "recorded")
    host.refresh_library()
    return status


def trash_behavior(host: SessionHost, message: TrashBehavior) -> StatusMessage:
    """Move a trained behavior to the trash."""
    trainer, name = host.trainer, message.name
    if trainer is not None and normalize_name(name) == normalize_name(trainer.name):
        raise SessionError(f"{name} is being trained: open another automaton before removing it")
    if trainer is not None and any(state.behavior == name for state in trainer.session.automaton.states):
        raise SessionError(
            f"{trainer.name}, which is being trained, uses {name}: remove it from the states of {trainer.name} first"
        )
    host.refresh_library()
    library.move_to_trash(host.library_view, name)
    host.refresh_library()
    return StatusMessage(f"{name} is in the trash, from where it can be restored")


def restore_behavior(host: SessionHost, message: RestoreBehavior) -> StatusMessage:
    """Bring a trained behavior back from the trash."""
    name = message.name
    host.refresh_library()
    library.restore_from_trash(host.library_view, name)
    host.refresh_library()
    return StatusMessage(f"{name} is back in the library")


def discard_session(host: SessionHost, message: DiscardSession) -> StatusMessage:
    """Discard an interrupted session; its journal is kept among the finished ones."""
    name = message.name
    host.refresh_interrupted()
    if name not in host.cut_off:
        where, names = "the interrupted lessons", list(host.cut_off)
        raise UnknownName(what="automaton", name=name, where=where, known=names)
    host.discarded[name] = interrupted_sessions.finish_journal(
        host.cut_off[name].path, host.library_view.folder, name
    )
    host.refresh_interrupted()
    return StatusMessage(f"Discarded the interrupted lesson of {name}")


def recall_session(host: SessionHost, message: RecallSession) -> StatusMessage:
    """Make a session that was discarded since the start of the studio available again."""
    name = message.name
    if name not in host.discarded:
        where, names = "the discarded lessons", list(host.discarded)
        raise UnknownName(what="automaton", name=name, where=where, known=names)
    interrupted_sessions.reopen_journal(host.discarded[name])
    del host.discarded[name]
    host.refresh_interrupted()
    return StatusMessage(f"The interrupted lesson of {name} can be resumed again")


class VersionData(Data, frozen=True, kw_only=True):
    """A former version of a behavior, and when it was saved."""

    number: int
    saved: str | None


class VersionsReply(Data, frozen=True, kw_only=True):
    """The former versions of a behavior, the latest first."""

    versions: list[VersionData]


class ChangeData(Data, frozen=True, kw_only=True):
    """The differences of two versions in one topic."""

    topic: str
    lines: list[str]
    """Lines that begin with + (added), - (removed), or neither."""


class MovedData(Data, frozen=True, kw_only=True):
    """A switch between two states whose conditions changed: those gone, those new, and the responsible examples."""

    state: str = field(name="from")
    next: str = field(name="to")
    what: HowMoved
    gone: list[str]
    new: list[str]
    examples: tuple[ExampleAttribution, ...]


class ChangesReply(Data, frozen=True, kw_only=True):
    """The differences between two versions."""

    changes: list[ChangeData]
    moved: list[MovedData]


def handle_list_versions(host: SessionHost, message: ListVersions) -> VersionsReply:
    """Return the former versions, latest first, and when each was saved."""
    host.library_view.find_automaton(message.name)
    versions = reversed(list_versions(host.library_view.folder, message.name))
    return VersionsReply(
        versions=[
            VersionData(number=each.number, saved=each.saved.isoformat() if each.saved else None)
            for each in versions
        ]
    )


def handle_diff_versions(host: SessionHost, message: DiffVersions) -> ChangesReply:
    """Compare a former version with another or the present one.

    Return the differing lines by topic, and the switches whose conditions changed with the responsible examples.
    """
    name, to = message.name, message.to
    before = _version(host, name, message.version)
    after = host.library_view.find_automaton(name) if to is None else _version(host, name, to)
    differences, switches = diff_automata(before, after), attribute_condition_changes(before, after)
    if switches:
        differences.pop("conditions", None)  # they say which, and why
    return ChangesReply(
        changes=[ChangeData(topic=topic, lines=lines) for topic, lines in differences.items()],
        moved=[MovedData.of(each) for each in switches],
    )


def revert_version(host: SessionHost, message: RevertVersion) -> StatusMessage | None:
    """Make a former version the present one; the present one becomes a former version."""
    name, number = message.name, message.version
    here = session.is_saved_in_training(host, name)
    host.refresh_library()
    host.library_view.find_automaton(name)
    taught = library.make_renamed_copy(
        host.library_view, _version(host, name, number), name
    )  # it may have had another name
    save_automaton(host.library_view.folder, taught)
    sentence = f"Restored version {number} of {name}; the version until now is kept, too"
    return session.reload_automaton(host, name, sentence, here=here)


def _version(host: SessionHost, name: str, number: int) -> TrainedAutomaton:
    return load_version(host.library_view.folder, name, number, host.kit, learn).taught


def rename_behavior(host: SessionHost, message: RenameBehavior) -> StatusMessage | None:
    """Rename a trained behavior and its former versions; SessionError if another automaton runs it."""
    name, to = message.name, message.to
    here = session.is_saved_in_training(host, name)
    trainer = host.trainer
    host.refresh_library()
    taught = host.library_view.find_automaton(name)
    users = [*host.library_view.library.find_users(name)]
    if trainer is not None and any(state.behavior == name for state in trainer.session.automaton.states):
        users.append(trainer.name)
    if users:
        runs = ", ".join(dict.fromkeys(users))
        raise SessionError(
            f"{runs} uses {name}: duplicate it instead, or remove it from the states of {runs} first"
        )
    host.library_view.refuse_new(to, remedy="give another name")
    library_folder.rename_automaton(
        host.library_view.folder, name, library.make_renamed_copy(host.library_view, taught, to)
    )
    return session.reload_automaton(host, to, f"Renamed {name} to {to}", here=here)


def duplicate_behavior(host: SessionHost, message: DuplicateBehavior) -> StatusMessage:
    """Copy a trained behavior as it is in the library."""
    name, to = message.name, message.to
    host.refresh_library()
    taught = host.library_view.find_automaton(name)
    host.library_view.refuse_new(to, remedy="give another name")
    library.save_copy(host.library_view, taught, to)
    host.refresh_library()
    return StatusMessage(f"{to} is a copy of {name}", "recorded")
