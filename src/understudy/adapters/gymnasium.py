"""Gymnasium environments as bodies, and scenarios with one robot as Gymnasium environments.

It needs the extra `gymnasium`; without it, the import raises ExtraMissing.
"""

from understudy.extras import require_extra

require_extra("gymnasium", what="a Gymnasium environment", extra="gymnasium")

from understudy.adapters.gymnasium_body import GymnasiumBody  # noqa: E402
from understudy.adapters.scenario_env import ScenarioEnv  # noqa: E402

__all__ = ["GymnasiumBody", "ScenarioEnv"]
