"""Checks that what you add to Understudy meets its contract.

    check_feature(my_feature, body)
    check_behavior(my_behavior, body)
    check_body(body)
    check_world(lambda seeds: MyWorld(seeds))

Each check raises LawBroken, whose message names the part and the rule that it breaks, or returns None. The checks
send commands to the body; a Rewindable body is restored afterwards.
"""

from understudy.testing.body_checks import check_body, check_world
from understudy.testing.kit_checks import check_behavior, check_feature
from understudy.testing.laws import LawBroken

__all__ = ["LawBroken", "check_behavior", "check_body", "check_feature", "check_world"]
