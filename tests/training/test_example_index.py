"""The index of examples says what counting all examples anew would say, whatever happens to them."""

import random

from understudy.model.lesson import Example, ExampleKind
from understudy.training.example_index import ExampleIndex, make_example_key

KINDS = (ExampleKind.DIRECTIVE, ExampleKind.DEFAULT, ExampleKind.WATCHED, ExampleKind.WATCHED)
VALUES = (0.0, 1.0, float("nan"))


def make_example(draw: random.Random, number: int, kind: ExampleKind | None = None) -> Example:
    state, following = draw.choices(["left", "right"], k=2)
    return Example(number, state, tuple(draw.choices(VALUES, k=2)), following, kind or draw.choice(KINDS))


def replace_one_by_one(examples: tuple[Example, ...], made: list[Example]) -> tuple[Example, ...]:
    pressed = {make_example_key(each) for each in made}
    kept = [each for each in examples if each.is_from_press or make_example_key(each) not in pressed]
    return (*kept, *made)


def test_the_index_is_that_of_all_examples() -> None:
    draw, index = random.Random(0), ExampleIndex()
    examples: tuple[Example, ...] = ()
    replaced = 0
    for _ in range(600):
        number = max((each.number for each in examples), default=0) + 1
        what = draw.random()
        if what < 0.4:
            made = [make_example(draw, number + offset, ExampleKind.DIRECTIVE) for offset in range(2)]
            index.update(examples)
            expected = replace_one_by_one(examples, made)
            replaced += len(examples) + len(made) > len(expected)
            examples = index.replace_watched(made)
            assert examples == expected
        elif what < 0.8:
            examples = (*examples, make_example(draw, number))
        elif examples:
            at = draw.randrange(len(examples))
            edited = make_example(draw, examples[at].number)
            later: dict[str, tuple[Example, ...]] = {
                "deleted": examples[at + 1 :],
                "edited": (edited, *examples[at + 1 :]),
                "undone": (),
                "undone, and taught otherwise": (
                    edited,
                    make_example(draw, number),
                    make_example(draw, number + 1),
                ),
            }
            examples = (*examples[:at], *later[draw.choices(list(later), [5, 5, 1, 1])[0]])
        index.update(examples)
        assert index.keys == {make_example_key(each) for each in examples}
        assert index.largest == max((each.number for each in examples), default=0)
    assert replaced > 20


def test_a_press_replaces_what_was_watched_with_the_same_readings() -> None:
    index = ExampleIndex()
    watched = Example(1, "left", (1.0, float("nan")), "left", ExampleKind.WATCHED)
    other = Example(2, "right", (1.0, float("nan")), "right", ExampleKind.WATCHED)
    index.update((watched, other))
    pressed = Example(3, "left", (1.0, float("nan")), "right", ExampleKind.DIRECTIVE)
    assert index.replace_watched([pressed]) == (other, pressed)
