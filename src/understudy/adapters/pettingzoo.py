"""Scenarios with any number of robots as parallel environments of PettingZoo.

It needs the extra `pettingzoo`; without it, the import raises ExtraMissing.
"""

from understudy.extras import require_extra

require_extra("pettingzoo", what="a PettingZoo environment", extra="pettingzoo")

from understudy.adapters.scenario_parallel_env import ScenarioParallelEnv  # noqa: E402

__all__ = ["ScenarioParallelEnv"]
