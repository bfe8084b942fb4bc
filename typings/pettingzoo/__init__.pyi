from typing import Any, Generic, TypeVar

from gymnasium import spaces

AgentID = TypeVar("AgentID")
ObsType = TypeVar("ObsType")
ActionType = TypeVar("ActionType")

class ParallelEnv(Generic[AgentID, ObsType, ActionType]):
    metadata: dict[str, Any]
    agents: list[AgentID]
    possible_agents: list[AgentID]
    observation_spaces: dict[AgentID, spaces.Space[Any]]
    action_spaces: dict[AgentID, spaces.Space[Any]]
