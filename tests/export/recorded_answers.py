"""What foreign programs answered to exports, recorded, so that they run only where what they are given changed.

A test asks a peer with `ask`, a fixture. All that decides the answer is hashed into its key: the exported files with
their rows, the command, and the version of the peer where it is pinned. If the record has an answer under this key,
it stands for the peer, and the test compares it with what the interpreter says today. Else the peer is asked where it
is installed; where it is not, the test is skipped, or fails in continuous integration (`CI` is set).

    python -m tests.export.record_conformance                 ask about what is new, and rewrite the record
    python -m tests.export.record_conformance --list-missing  exit with 1 if a peer has to be asked
    UNDERSTUDY_PEERS=run pytest tests/export                  ask all peers, and compare with the record
"""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple, NoReturn

import pytest
from tests.export.peers import Peer, list_peers, run_peer

RECORD = Path(__file__).with_name("recorded_answers.txt")
PEERS = "UNDERSTUDY_PEERS"
"""The variable of the environment that is `run` where all peers are to be asked."""
COUNTS = r"\d+ ticks, \d+ mismatches"
NOT_GIVEN = ("manifest.json", "README.md")
"""Files of an export that no peer reads."""
REMEDY = "record the answers where all peers are installed: python -m tests.export.record_conformance"


class Answer(NamedTuple):
    """Whether a peer succeeded, and what was looked for in what it printed."""

    succeeded: bool
    said: str

    @property
    def counts(self) -> tuple[int, int]:
        """The numbers of ticks and of mismatches."""
        ticks, mismatches = re.findall(r"\d+", self.said)
        return int(ticks), int(mismatches)


class UnrecordedAnswer(UserWarning):
    """A peer was asked, since the record does not have its answer."""


@dataclass
class Answers:
    """The recorded answers by their keys, and what was asked for in this session.

    `asked` has the answers in use by key, with the peer and the first test. `is_listing` means that no peer is asked:
    tests whose answer is not recorded end there.
    """

    recorded: Mapping[str, Answer]
    asked: dict[str, tuple[str, str, Answer | None]] = field(default_factory=dict)
    is_listing: bool = False
    asks_all: bool = False

    def find(self, key: str, peer: str, test: str, question: Callable[[], Answer]) -> Answer:
        """Return the recorded answer to a question, or ask it."""
        known = self.recorded.get(key)
        self.asked.setdefault(key, (peer, test, known))
        if self.is_listing and known is None:
            pytest.skip(f"{peer} has to be asked")
        if known is not None and (self.is_listing or not self.asks_all):
            return known
        if problem := list_peers()[peer].find_missing():
            _miss(f"{problem} (the export to {peer} or its rows changed; or {REMEDY})")
        answer = question()
        if known is not None and answer != known:
            pytest.fail(f"{peer} answers {answer}; recorded is {known}")
        if known is None:
            self.asked[key] = (peer, test, answer)
            _warn(f"{peer} was asked; {REMEDY}")
        return answer


def _miss(sentence: str) -> NoReturn:
    if os.environ.get("CI"):
        pytest.fail(sentence)
    pytest.skip(sentence)


def _warn(sentence: str) -> None:
    warnings.simplefilter("always", UnrecordedAnswer)  # within a test, for this test: others are errors
    warnings.warn(sentence, UnrecordedAnswer, stacklevel=2)


ANSWERS = pytest.StashKey[Answers]()
"""Where the configuration of a test run has them."""


def read_record(text: str) -> dict[str, Answer]:
    """Read a record: of each line its key, the peer, the test, whether it succeeded, and what the peer said."""
    lines = (line.split("\t") for line in text.splitlines() if not line.startswith("#"))
    return {key: Answer(ended == "succeeded", json.loads(said)) for _, _, key, ended, said in lines}


def write_record(asked: Mapping[str, tuple[str, str, Answer | None]], heading: str) -> str:
    """Write a record, sorted by test and peer."""
    lines = []
    for key, (peer, test, answer) in asked.items():
        if answer is not None:
            ended = "succeeded" if answer.succeeded else "failed"
            lines.append("\t".join((test, peer, key, ended, json.dumps(answer.said, ensure_ascii=False))))
    return "".join(f"{line}\n" for line in (heading, *sorted(lines)))


def name_test(nodeid: str) -> str:
    """Name a test of exports as the record does."""
    return nodeid.removeprefix("tests/export/")


def hash_question(peer: str, folder: Path, *parts: str) -> str:
    """Hash what decides an answer: the peer, the files that it is given, and all else that is said to it."""
    digest = sha256()
    for part in (peer, list_peers()[peer].version, *parts):
        _add(digest.update, part.encode())
    for path in sorted(folder.rglob("*"), key=lambda path: path.relative_to(folder).as_posix()):
        if path.is_file() and path.name not in NOT_GIVEN:
            _add(digest.update, path.relative_to(folder).as_posix().encode())
            _add(digest.update, path.read_bytes())
    return digest.hexdigest()[:20]


def _add(update: Callable[[bytes], None], part: bytes) -> None:
    update(b"%d:" % len(part))
    update(part)


def hash_text(content: bytes) -> str:
    """Hash a file that is too long for the record."""
    return sha256(content).hexdigest()[:20]


@dataclass
class Ask:
    """Asks peers on behalf of a test."""

    answers: Answers
    test: str

    def __call__(
        self,
        peer: str,
        folder: Path,
        *targets: str,
        command: tuple[str, ...] = (),
        finds: str = COUNTS,
        hashes: str = "",
        given: str = "",
    ) -> Answer:
        """Ask a peer about the files of a folder.

        Parameters
        ----------
        peer
            Its name.
        folder
            The folder, which is left as it is: the peer gets a copy.
        targets
            Of `make`, and values of its variables. None: those of the peer's own test.
        command
            A command instead of `make`.
        finds
            A pattern of what is looked for in what the peer prints.
        hashes
            A file whose hash is the answer instead.
        given
            What is written to its standard input.

        Returns
        -------
        Answer
            Whether the command succeeded, and all that was found, each on a line.
        """
        described = list_peers()[peer]
        words = command or ("make", *(targets or described.words))
        key = hash_question(peer, folder, *words, finds, hashes, given)

        def question() -> Answer:
            with tempfile.TemporaryDirectory() as place:
                copy = shutil.copytree(folder, Path(place) / "given")
                return _put(described, copy, words, finds, hashes, given)

        return self.answers.find(key, peer, self.test, question)

    def by(self, peer: str, folder: Path, *parts: str, question: Callable[[], Answer]) -> Answer:
        """Return the answer that a function gets, which depends on the files of a folder and these parts alone."""
        return self.answers.find(hash_question(peer, folder, *parts), peer, self.test, question)


def _put(peer: Peer, folder: Path, words: tuple[str, ...], finds: str, hashes: str, given: str) -> Answer:
    done = run_peer(peer, folder, words, given)
    printed = done.stdout + done.stderr
    succeeded = done.returncode == 0
    if succeeded:
        assert "warning" not in done.stderr.lower(), done.stderr
    if hashes:
        assert succeeded, printed
        return Answer(True, hash_text((folder / hashes).read_bytes()))
    found = [" ".join(each[0].split()) for each in re.finditer(finds, printed)] if finds else []
    assert found or not finds, printed
    return Answer(succeeded, "\n".join(found))
