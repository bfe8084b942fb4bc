"""Parallel environments of PettingZoo as bodies, and scenarios with any number of robots as such environments.

It needs the extra `pettingzoo`; without it, the import raises ExtraMissing.
"""

from understudy.extras import require_extra

require_extra("pettingzoo", what="a PettingZoo environment", extra="pettingzoo")

from understudy.adapters.pettingzoo_body import PettingZooBody  # noqa: E402
from understudy.adapters.scenario_parallel_env import ScenarioParallelEnv  # noqa: E402

__all__ = ["PettingZooBody", "ScenarioParallelEnv"]
