"""Draws the pictures of the README with Understudy itself: python docs/pictures/draw.py

Teaches a robot as `understudy demo --seed 1` does, and draws what it learned and one way it went.
"""

from pathlib import Path

from understudy.experiments.forage.teaching import teach
from understudy.model.automaton import Automaton
from understudy.model.conditions import conditions
from understudy.model.tree import Tree
from understudy.pictures import automaton_svg, path_png
from understudy.runtime.program import link
from understudy.runtime.run import Run
from understudy.worlds.forage import Forage
from understudy.worlds.forage_view import Frame

HERE = Path(__file__).parent
WORLD = 141


def drawn(automaton: Automaton) -> str:
    """The automaton as SVG."""
    names, said = automaton.state_names, {}
    for state, tree in automaton.transitions.items():
        if isinstance(tree, Tree):
            for outcome, texts in conditions(tree, automaton.features).items():
                said[state, names[outcome]] = texts
    return automaton_svg(automaton, said)


def main() -> None:
    """Teach, run, draw."""
    library = teach(1).library
    (HERE / "goto.svg").write_text(drawn(library.automaton("goto")), encoding="utf-8")
    body = Forage([WORLD])
    run = Run.of(body, link(library, "forage"))
    frames = []
    while not body.success()[0]:
        run.tick()
        frames.append(Frame(body.view(), run.interpreters[0].path[0]))
    path_png(frames, HERE / "foraging.png", title="forage, taught by pressing 37 times")


if __name__ == "__main__":
    main()
