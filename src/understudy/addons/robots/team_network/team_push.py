"""Hand a library to all agents of a team: each checks it first, then all replace theirs, or all go back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from understudy.addons.robots.team_network.agent_questions import AgentAnswer, AgentQuestion
from understudy.addons.robots.team_network.library_push import Files

AskAgents = Callable[[AgentQuestion], Mapping[str, AgentAnswer]]
"""A function that asks all agents, and returns the answers of those that gave one."""


class WhichLibrary(StrEnum):
    """The library that is on an agent's disk after a push."""

    NEW = "new"
    FORMER = "former"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class PushResult:
    """The result of a push at one agent.

    Attributes
    ----------
    library
        The library on its disk.
    problem
        Why it refused, could not go back, or does not run the new library; empty if nothing was wrong with this agent.
    """

    library: WhichLibrary
    problem: str = ""

    def describe(self) -> str:
        """Return a sentence without its subject, the agent."""
        sentence = {
            WhichLibrary.NEW: "has the new library",
            WhichLibrary.FORMER: "has the former library",
            WhichLibrary.UNKNOWN: "has the new library or the former one",
        }[self.library]
        if not self.problem:
            return sentence
        runs = ", and runs it once it is started again" if self.library == WhichLibrary.NEW else ""
        return f"{sentence}{runs} ({self.problem})"


def describe_push(results: Mapping[str, PushResult]) -> list[str]:
    """Describe a push: a line for each agent, and one for all unless all have the new library."""
    lines = [f"{agent}: {result.describe()}." for agent, result in results.items()]
    libraries = {result.library for result in results.values()}
    if libraries == {WhichLibrary.FORMER}:
        lines.append("All have the former library: nothing was changed.")
    elif libraries != {WhichLibrary.NEW}:
        lines.append("Agents may have different libraries: push again once all are there.")
    return lines


def push_library(
    ask_all: AskAgents, files: Files, *, agents: Sequence[str], by: str
) -> dict[str, PushResult]:
    """Hand a library to all agents of a team.

    All agents check it while they go on; then all replace theirs on disk; then all restart with it. If one refuses
    or does not answer before the last step, those that replaced theirs are asked to go back.

    Parameters
    ----------
    ask_all
        A function that asks all agents.
    files
        The documents of the library.
    agents
        The names of the agents that must have it.
    by
        The person who hands it over.

    Returns
    -------
    dict
        What became of it at each agent, by its name.
    """

    def find_problems(question: AgentQuestion, silent: str) -> dict[str, str]:
        answers = ask_all(question)
        return {agent: answers[agent].problem if agent in answers else silent for agent in agents}

    problems = find_problems(AgentQuestion("prepare", by, dict(files)), "is not there")
    if any(problems.values()):
        ask_all(AgentQuestion("forget", by))
        return {agent: PushResult(WhichLibrary.FORMER, problem) for agent, problem in problems.items()}
    problems = find_problems(AgentQuestion("switch", by), "did not answer")
    if not any(problems.values()):
        problems = find_problems(AgentQuestion("restart", by), "did not answer")
        return {agent: PushResult(WhichLibrary.NEW, problem) for agent, problem in problems.items()}
    returned = ask_all(AgentQuestion("forget", by))
    return {
        agent: _describe_return(returned.get(agent), refusal=problem) for agent, problem in problems.items()
    }


def _describe_return(answer: AgentAnswer | None, *, refusal: str) -> PushResult:
    """Describe an agent that was asked to go back, which may have refused the new library before."""
    if answer is None:
        return PushResult(WhichLibrary.UNKNOWN, refusal or "did not answer when asked to go back")
    if answer.problem:
        return PushResult(WhichLibrary.NEW, answer.problem)
    return PushResult(WhichLibrary.FORMER, refusal)
