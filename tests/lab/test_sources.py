"""The hash of a study's sources changes with everything on which its rows depend, and with nothing else."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.lab import reproduced
from tests.lab.reproduced import (
    Reproduced,
    find_test_sources,
    is_reproduced,
    list_retraining_files,
    read_record,
)

from understudy_lab.results import find_row_sources, fingerprint
from understudy_lab.sources import LABORATORY, PACKAGES, describe_environment, find_sources, hash_sources
from understudy_lab.study import QUESTIONS, folder_of

PRODUCT = LABORATORY.with_name("understudy")


def own(path: Path) -> str:
    """A file of either package by its path from the folder of both."""
    return path.relative_to(LABORATORY.parent).as_posix()


@pytest.fixture(scope="module")
def sources_copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of all sources."""
    folder = tmp_path_factory.mktemp("src")
    for package in PACKAGES:
        for path in (*package.rglob("*.py"), *package.rglob("*.toml")):
            target = folder / path.relative_to(package.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)
    return folder


EDITS = [  # a file, text in place of its last line, whether rows of the study `forage` depend on it
    ("understudy/learning/tree_growth.py", "CHANGED = 1", True),
    ("understudy/learning/_split_kernels.py", "CHANGED = 1", True),
    ("understudy/model/tree.py", "CHANGED = 1", True),
    ("understudy/training/session.py", "CHANGED = 1", True),
    ("understudy/runtime/engine/_pulse_kernels.py", "CHANGED = 1", True),
    ("understudy/sim/kernels/tick.py", "CHANGED = 1", True),
    ("understudy/sim/scenarios/forage.toml", "changed = 1", True),
    ("understudy_lab/teachers/person.py", "CHANGED = 1", True),
    ("understudy_lab/forage/study.py", "CHANGED = 1", True),
    ("understudy/learning/tree_growth.py", "# a remark", False),
    ("understudy/learning/tree_growth.py", '"""A text that is no statement."""', False),
    ("understudy/ui/web/server.py", "CHANGED = 1", False),
    ("understudy/addons/export/body_interface.py", "CHANGED = 1", False),
    ("understudy/addons/robots/safety/watchdog.py", "CHANGED = 1", False),
    ("understudy_lab/novices/study.py", "CHANGED = 1", False),
]


@pytest.mark.parametrize(("name", "text", "matters"), EDITS)
def test_an_edit_changes_the_hash_where_rows_depend_on_it(
    sources_copy: Path, name: str, text: str, matters: bool
) -> None:
    packages = [sources_copy / package.name for package in PACKAGES]
    root, path = sources_copy / "understudy_lab" / "forage" / "study.py", sources_copy / name

    def hash_packages() -> str:
        return hash_sources(find_sources([root], packages))

    before, content = hash_packages(), path.read_text(encoding="utf-8")
    try:
        path.write_text(f"{content}\n{text}\n", encoding="utf-8")
        assert (hash_packages() != before) == matters
    finally:
        path.write_text(content, encoding="utf-8")
    assert hash_packages() == before


FILES = {
    "p/__init__.py": "",
    "p/root.py": "import p.module\nfrom p.a import b\nfrom p import c as d\n",
    "p/module.py": "import json\n",
    "p/a/__init__.py": "",
    "p/a/b.py": "def work():\n    from p.late import name\n",
    "p/late.py": "import sys\nsys.modules['p.by_name']\n",
    "p/by_name.py": "",
    "p/c.py": "if TYPE_CHECKING:\n    import p.types\nelse:\n    import p.otherwise\n",
    "p/types.py": "",
    "p/otherwise.py": "",
    "p/unused.py": "",
    "p/scenarios/world.toml": "",
}


def test_sources_are_what_is_imported_directly_or_not(tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    found = find_sources([tmp_path / "p" / "root.py"], [tmp_path / "p"])
    assert {path.relative_to(tmp_path).as_posix() for path in found} == set(FILES) - {
        "p/types.py",
        "p/unused.py",
    }


def test_rows_depend_on_every_experiment_that_theirs_imports() -> None:
    used = {own(path) for path in find_row_sources("ablation")}
    assert {"understudy_lab/ablation/variants.py", "understudy_lab/forage/teach.py"} <= used
    assert {"understudy_lab/statistics.py", "understudy_lab/tasks/forage_expert.py"} <= used
    assert not any("novices" in path for path in used)


@pytest.mark.parametrize("name", QUESTIONS)
def test_rows_of_every_experiment_depend_on_the_learner_and_never_on_the_interface(name: str) -> None:
    used = {own(path) for path in find_row_sources(name)}
    assert {"understudy/learning/tree_growth.py", "understudy/learning/_split_kernels.py"} <= used
    assert own(folder_of(name) / "study.py") in used
    assert not any(path.startswith(("understudy/ui/", "understudy/addons/export/")) for path in used)
    assert len(fingerprint(name)) == 16


@pytest.fixture
def foreign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of another distribution with a study."""
    (tmp_path / "meadow").mkdir()
    for name, text in {
        "__init__": "",
        "grass": "BLADES = 1",
        "study": "from understudy_lab.study import *\nfrom meadow.grass import BLADES\n"
        "def work(task): return {}\n"
        "study = Study('meadow', range(1), 1, lambda plan: [], work, StudyFindings, lambda rows: None)\n",
    }.items():
        (tmp_path / "meadow" / f"{name}.py").write_text(text)
    information = tmp_path / "meadow-1.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: meadow\nVersion: 1\n")
    (information / "entry_points.txt").write_text("[understudy.studies]\nmeadow = meadow.study:study\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path / "meadow"
    for name in [name for name in sys.modules if name.partition(".")[0] == "meadow"]:
        del sys.modules[name]


def test_rows_of_an_experiment_of_another_package_depend_on_it(foreign: Path) -> None:
    assert {path for path in find_row_sources("meadow") if path.is_relative_to(foreign)} == {
        foreign / "__init__.py",
        foreign / "study.py",
        foreign / "grass.py",
    }


def test_public_names_depend_on_the_modules_that_define_them(tmp_path: Path) -> None:
    study = tmp_path / "study.py"
    study.write_text("from understudy import evaluate\nfrom understudy.spi import Transport\n")
    found = {own(path) for path in find_sources([study]) - {study}}
    assert {"understudy/judging/evaluate.py", "understudy/addons/robots/ros/transport.py"} <= found
    assert "understudy/ui/cli/plugins.py" not in found  # of another name


def test_the_environment_names_what_decides_numbers() -> None:
    python = f"Python {sys.version_info.major}.{sys.version_info.minor}, "
    assert describe_environment().startswith(python)
    assert all(name in describe_environment() for name in ("numba 0.", "numpy ", "llvmlite 0."))


# Which tests need not retrain


def test_the_record_names_only_files_of_retraining_tests() -> None:
    assert set(read_record().sources) <= {path.name for path in list_retraining_files()}
    assert len(list_retraining_files()) >= 17


def test_a_test_retrains_unless_sources_and_environment_are_those_recorded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    file = Path(__file__).with_name("test_servoing.py")
    known = {file.name: reproduced.hash_test(file)}
    for record, expected in (
        (Reproduced(describe_environment(), known), True),
        (Reproduced("Python 2.7", known), False),
        (Reproduced(describe_environment(), {file.name: "0"}), False),
        (Reproduced(describe_environment(), {}), False),
    ):
        monkeypatch.setattr(reproduced, "read_record", lambda record=record: record)
        assert is_reproduced(file) is expected


def test_a_retraining_test_depends_on_itself_its_helpers_and_the_published_rows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    file = Path(__file__).with_name("test_novices.py")
    found = {path.name for path in find_test_sources(file)}
    assert {"test_novices.py", "test_servoing.py", "lessons.py", "study.py", "fit.py"} <= found
    hashed: list[set[str]] = []
    monkeypatch.setattr(
        reproduced,
        "hash_sources",
        lambda files: hashed.append({own(each) for each in files if each.is_relative_to(LABORATORY)}),
    )
    reproduced.hash_test.__wrapped__(file)
    assert "understudy_lab/novices/expected.json.gz" in hashed[0]
