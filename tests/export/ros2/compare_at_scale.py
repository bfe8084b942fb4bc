"""Run exported nodes of random libraries beside Understudy for long: python -m tests.export.ros2.compare_at_scale."""

from __future__ import annotations

import argparse
import sys
import tempfile
from itertools import count
from pathlib import Path

from tests.export.exports import LIVELY
from tests.export.ros2.packages import build_node, write_stand_ins
from tests.export.ros2.robots import (
    ReferenceNode,
    draw_library,
    draw_steps,
    list_moves,
    run_node,
    write_robot,
)

from understudy.addons.export.body_interface import describe_robot
from understudy.addons.export.export_automaton import export_automaton, prepare_export
from understudy.addons.robots.robot_file import load_robot


def main() -> int:
    """Compare as many libraries as asked for, of which each decides in several ways."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--libraries", type=int, default=10)
    parser.add_argument("--seconds", type=int, default=1000)
    parser.add_argument("--first", type=int, default=100)
    arguments = parser.parse_args()
    done = ticks = different = 0
    for seed in count(arguments.first):
        if done == arguments.libraries:
            break
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            path, library = write_robot(folder), draw_library(seed)
            interface = describe_robot(load_robot(path), path=path)
            job = prepare_export(
                library, "a2", to="ros2", binding={}, body=interface.body, fingerprint="", robot=interface
            )
            if job.conformance.leaves[0] < 2 * LIVELY or len(job.hierarchy.automata) < 2:
                continue
            export_automaton(library, "a2", folder / "out", to="ros2", body=interface)
            write_stand_ins(folder / "out", folder)
            program = build_node(folder / "out", folder)
            steps = draw_steps(seed, arguments.seconds, node="a2")
            found = run_node(program, steps)
            expected = ReferenceNode(path, library, "a2", interface).follow(steps)
            same = found.commands[: len(expected.commands)] == expected.commands
            equal = same and found.paths == expected.paths and found.answers == expected.answers
            done += 1
            ticks += 10 * arguments.seconds
            different += not equal
            moves = len(list(list_moves(found)))
            sys.stdout.write(
                f"random {seed}: {len(found.commands)} commands, {moves} of which move it, {len(found.paths)} changes "
                f"of states {'equal' if equal else 'DIFFER'}\n"
            )
            sys.stdout.flush()
    sys.stdout.write(f"{ticks} ticks, {different} libraries differ\n")
    return bool(different)


if __name__ == "__main__":
    raise SystemExit(main())
