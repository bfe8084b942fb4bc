"""Checks that what you add to Understudy meets its contract; `understudy.spi` has the contracts.

    check_feature(my_feature, body)
    check_behavior(my_behavior, body)
    check_kit(my_kit, body)
    check_body(body)
    check_world(lambda seeds: MyWorld(seeds))
    check_scenario_worlds(make_my_scenario)
    check_export_target(my_target, library, "goto", binding={"A": "station"})
    check_reader(read_my_recording, "drive.rec")
    check_transport(open_my_transport, robot_file)
    check_command(my_command)
    check_study(my_study)
    check_baseline(find_my_baseline, scenario)

Each check raises LawBroken, whose message names the part and the rule that it breaks, or returns None. The checks
send commands to a body; a Rewindable body is restored afterwards.
"""

from understudy.testing.body_checks import check_body, check_scenario_worlds, check_world
from understudy.testing.command_check import check_command
from understudy.testing.kit_checks import check_behavior, check_feature, check_kit
from understudy.testing.laws import LawBroken
from understudy.testing.reader_check import check_reader
from understudy.testing.study_checks import check_baseline, check_study
from understudy.testing.target_check import check_export_target
from understudy.testing.transport_check import check_transport

__all__ = [
    "LawBroken",
    "check_baseline",
    "check_behavior",
    "check_body",
    "check_command",
    "check_export_target",
    "check_feature",
    "check_kit",
    "check_reader",
    "check_scenario_worlds",
    "check_study",
    "check_transport",
    "check_world",
]
