"""`understudy simplify`: what an automaton would be with fewer questions, shown before anything is changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.ui.cli.options import LIBRARY, Json, KitName, LibraryOption, SomeWorld

if TYPE_CHECKING:
    from understudy.analysis.simplify_preview import SimplifyPreview

MOST_DECISIONS = 12


def simplify(
    name: Annotated[str, typer.Argument(help="The automaton.")],
    library: LibraryOption = LIBRARY,
    pruning: Annotated[
        float | None,
        typer.Option(
            "--pruning",
            "-p",
            min=0,
            help="A question stays if each of its leaves sets more examples right; 0 takes it back.",
            show_default=False,
        ),
    ] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Save it so, as an option of the lesson.")] = False,
    world: SomeWorld = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Show an automaton with fewer questions: its conditions before and after, and the decisions that would change.

    Nothing is changed without --keep. What is kept can be taken back with --pruning 0 --keep.

    [dim]understudy simplify goto --library demo/library[/]
    """
    from understudy.analysis.simplify_preview import make_simplify_error, preview_simplification
    from understudy.storage.library_folder import make_file_stem, read_document, save_automaton
    from understudy.ui.cli.options import find_optional_kit, import_learner
    from understudy.ui.cli.output import print_json

    path = library / f"{make_file_stem(name)}.json"
    taught = read_document(path, find_optional_kit(kit, world), import_learner()).taught
    found = preview_simplification(taught, pruning)
    if pruning is None and found.suggested is None and keep:
        problem, remedy = "has too few examples to tell what could go", "say how much with --pruning"
        raise make_simplify_error(name, problem, remedy)
    told = {**_facts(found), "kept": keep}
    if keep:
        save_automaton(library, found.after)
    if as_json:
        print_json(told)
    else:
        _show(told, chosen=pruning is not None)


def _facts(found: SimplifyPreview) -> dict[str, Any]:
    """Conditions before and after, and the decisions on recorded moments that would change."""
    suggested, replay, leaves = found.suggested, found.replayed, found.leaves
    return {
        "name": found.before.automaton.name,
        "pruning": found.pruning,
        "suggested": None
        if suggested is None
        else {
            "pruning": suggested.pruning,
            "left_out": suggested.examples,
            "wrong": suggested.wrong,
            "wrong_pruned": suggested.wrong_pruned,
        },
        "leaves": {"before": leaves[0], "after": leaves[1]},
        "conditions": {
            state: {"before": before, "after": after} for state, (before, after) in found.conditions.items()
        },
        "decisions": [
            {
                "number": each.number, "kind": each.kind, "state": each.state,
                "shown": each.shown, "before": each.formerly, "after": each.now,
            }
            for each in found.decisions
        ],
        "examples": replay.examples,
        "changes_before_presses": [
            {"state": each.state, "before": each.formerly, "after": each.now, "moments": each.moments}
            for each in replay.changes
        ],
        "moments_before_presses": replay.before,
    }  # fmt: skip


def _show(told: dict[str, Any], *, chosen: bool) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.learning.pruning_suggestions import ENOUGH
    from understudy.ui.cli.output import format_count, make_console

    out, found = make_console(), told["suggested"]
    before, after = told["leaves"]["before"], told["leaves"]["after"]
    head = f"[bold]{escape(told['name'])}[/] pruned by {told['pruning']:.3g}"
    out.print(f"{head}: {format_count(before, 'answer')} before, {after} after", soft_wrap=True)
    if found is not None:
        wrong = f"{found['wrong_pruned']} of {found['left_out']} wrong, {found['wrong']} without pruning"
        out.print(
            f"[dim]suggested: {found['pruning']:.3g}; examples left out in turn: {wrong}[/]", soft_wrap=True
        )
    elif not chosen:
        few = f"It has fewer than {ENOUGH} examples, and each of them was meant: better leave it as it is."
        out.print(f"[dim]{few}[/]", soft_wrap=True)
    for state, both in told["conditions"].items():
        out.print(f"\n[cyan]{escape(state)}[/]")
        kept = [line for line in both["before"] if line in both["after"]]
        for color, mark, lines in (
            ("default", " ", kept),
            ("red", "-", both["before"]),
            ("green", "+", both["after"]),
        ):
            for line in lines:
                if mark == " " or line not in kept:
                    out.print(Padding(f"[{color}]{mark} {escape(line)}[/]", (0, 0, 0, 2), expand=False))
    if not told["conditions"]:
        out.print("nothing would change" if not told["kept"] else "nothing changed")
    if told["conditions"]:
        out.print()
    for line in _decisions(told):
        out.print(Padding(escape(line), (0, 0, 0, 2), expand=False))
    if told["conditions"] and not told["kept"]:
        how = "--keep" if found is not None else f"--pruning {told['pruning']:g} --keep"
        out.print(f"[dim]Nothing was changed: {how} saves it so.[/]")
    elif told["conditions"] and told["pruning"]:
        out.print("Kept; --pruning 0 --keep takes it back")


def _decisions(told: dict[str, Any]) -> list[str]:
    """What would be decided otherwise, a line each."""
    if not told["conditions"]:
        return []
    rows = told["decisions"]
    lines = [f"{len(rows)} of {told['examples']} examples would be decided otherwise"]
    for row in rows[:MOST_DECISIONS]:
        right = "as shown" if row["after"] == row["shown"] else f"shown: {row['shown']}"
        lines.append(f"{row['number']} in {row['state']}: {row['before']} → {row['after']} ({right})")
    if len(rows) > MOST_DECISIONS:
        lines.append(f"and {len(rows) - MOST_DECISIONS} more")
    if told["moments_before_presses"]:
        total = sum(row["moments"] for row in told["changes_before_presses"])
        lines.append(f"{total} of {told['moments_before_presses']} moments before presses, too")
    return lines
