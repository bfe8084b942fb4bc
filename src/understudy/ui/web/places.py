"""The scenarios and the libraries that the studio offers: those on this disk beside the ones it was started with."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from understudy.errors import SessionError, UnderstudyError, UnknownName
from understudy.model.library import Kit
from understudy.sim.catalog import find_scenario, list_scenarios
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import SUFFIX, format_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.validate_names import NAME
from understudy.storage.atomic_write import convert_os_errors, lock_folder, write_atomically
from understudy.ui.controller.training_plan import check_new_name
from understudy.ui.web.messages.base import Data

SCENARIOS = "scenarios"
"""The folder of saved scenarios, beside the library."""
MOST_FOLDERS = 200
"""So many folders beside the library are looked into."""
DOCUMENT = b'"automaton"'
"""What the first bytes of an automaton's document contain."""


class PlacesData(Data, frozen=True, kw_only=True):
    """The scenarios and libraries that can be chosen, and the present ones."""

    world: str
    worlds: list[str]
    library: str
    libraries: list[str]
    can_save: bool
    """Whether the world can be saved as a scenario, and another be chosen."""


class Places:
    """The scenarios and libraries at hand. `scenario` and `kit` are those that the studio was started with."""

    def __init__(self, scenario: Scenario, kit: Kit, library: Path) -> None:
        self._scenario, self._kit = scenario, kit
        self._beside = library.absolute().parent

    @property
    def scenarios(self) -> Path:
        """The folder of saved scenarios."""
        return self._beside / SCENARIOS

    def list_worlds(self) -> list[str]:
        """List the names of scenarios: the first one, built-in ones, those of installed packages, and saved ones."""
        saved = (path.stem for path in self.scenarios.glob(f"*{SUFFIX}"))
        return sorted({self._scenario.name, *list_scenarios(), *saved})

    def open_world(self, name: str) -> tuple[Scenario, Kit]:
        """Return a scenario of the list with its kit; UnknownName for any other."""
        if name == self._scenario.name:
            return self._scenario, self._kit
        names = self.list_worlds()
        if name not in names:
            raise UnknownName(what="world", name=name, where="the studio", known=names)
        path = self.scenarios / f"{name}{SUFFIX}"
        scenario = find_scenario(path if path.is_file() else name)
        return scenario, make_scenario_kit(scenario)

    def find_kit(self, scenario: Scenario) -> Kit:
        """Return the kit of a scenario: for worlds of the first one, the kit that the studio was started with."""
        return self._kit if scenario.name == self._scenario.name else make_scenario_kit(scenario)

    def save_world(self, scenario: Scenario) -> Path:
        """Save a scenario under its name; SessionError if the name is taken, or no name of a scenario."""
        name = scenario.name
        if not NAME.fullmatch(name):
            raise SessionError(f"{name!r} cannot be the name of a world: use letters, digits, - and _")
        if name.casefold() in {each.casefold() for each in self.list_worlds()}:
            raise SessionError(f"there is a world {name} already: give another name")
        path = self.scenarios / f"{name}{SUFFIX}"
        with convert_os_errors(path, "saving the world"):
            self.scenarios.mkdir(exist_ok=True)
            with lock_folder(self.scenarios):
                write_atomically(path, format_scenario(scenario).encode())
        return path

    def list_libraries(self, present: Path) -> list[str]:
        """List the names of the libraries in the folder of the present one, which is among them."""
        return sorted({present.absolute().name, *(folder.name for folder in self._libraries())})

    def _libraries(self) -> Iterator[Path]:
        """Yield the folders beside the library that have automata."""
        with suppress(OSError):
            folders = [each for each in sorted(self._beside.iterdir()) if each.is_dir()]
            for folder in folders[:MOST_FOLDERS]:
                with suppress(OSError):
                    if any(_is_document(path) for path in folder.glob("*.json")):
                        yield folder

    def open_library(self, name: str, present: Path) -> Path:
        """Return the folder of a library of the list, or that of a new one, which is made when something is saved."""
        folder = self._beside / name
        if name in self.list_libraries(present):
            return folder
        check_new_name(name, "a library")
        if folder.exists():
            raise SessionError(f"{name} is there already, and no library: give another name")
        return folder

    def data(self, world: Scenario, library: Path, *, saves: bool) -> PlacesData:
        """Return what can be chosen, as the page shows it."""
        return PlacesData(
            world=world.name,
            worlds=self.list_worlds() if saves else [world.name],
            library=library.absolute().name,
            libraries=self.list_libraries(library),
            can_save=saves,
        )


def _is_document(path: Path) -> bool:
    with suppress(OSError, UnderstudyError):
        if path.is_file():  # a pipe would be waited for without end
            with path.open("rb") as file:
                return DOCUMENT in file.read(200)
    return False
