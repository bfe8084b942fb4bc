"""The command line as a module, and completion of its words by shells."""

from __future__ import annotations

import runpy
import sys

import pytest
from typer.testing import CliRunner

from understudy import __version__
from understudy.ui.cli.main import make_command_line


def complete(shell: str, words: str) -> list[str]:
    """Return what a shell is told for a command line whose last word is begun, as lines."""
    environment = {
        "_UNDERSTUDY_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
        "_TYPER_COMPLETE_ARGS": words,
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
    }
    told = CliRunner(env=environment).invoke(make_command_line(), [], prog_name="understudy")
    assert told.exit_code == 0, told.output
    return told.stdout.split("\n")


WORDS = [  # what is typed, and what is offered, among others
    ("understudy sh", ["show"], ["list", "Usage: understudy COMMAND [ARGUMENTS] [OPTIONS]"]),
    ("understudy robots st", ["studio", "stop", "stops"], ["check"]),
    ("understudy learn ", ["table", "recording", "drive", "drivers"], ["learn"]),
    ("understudy show --lib", ["--library"], ["--world"]),
    ("understudy check demo/library --fail-on ", ["error", "warning", "note", "never"], []),
]


@pytest.mark.parametrize(("words", "offered", "others"), WORDS)
def test_words_are_completed(words: str, offered: list[str], others: list[str]) -> None:
    found = complete("bash", words)
    assert set(offered) <= set(found)
    assert not set(others) & set(found)
    for shell in ("zsh", "fish"):
        told = "\n".join(complete(shell, words))
        assert all(each in told for each in offered)


@pytest.mark.parametrize(
    ("shell", "registers"),
    [
        ("bash", "complete -o default -F _understudy_completion understudy"),
        ("zsh", "compdef _understudy_completion understudy"),
        ("fish", "complete --command understudy"),
    ],
)
def test_there_is_a_script_for_each_shell(shell: str, registers: str) -> None:
    runner = CliRunner(env={"_UNDERSTUDY_COMPLETE": f"source_{shell}"})
    told = runner.invoke(make_command_line(), [], prog_name="understudy")
    assert (told.exit_code, registers in told.stdout) == (0, True)


@pytest.mark.parametrize("module", ["understudy", "understudy.ui.cli"])
def test_the_command_line_runs_as_a_module(
    module: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [module, "--version"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module(module, run_name="__main__")
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"understudy {__version__}\n"
