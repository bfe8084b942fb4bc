"""Write the studio as static files, which any web server can serve: `python tools/page_site.py site-studio`.

The page is the one that `understudy studio` serves. Python, NumPy, msgspec and Understudy lie beside it, in a folder
that is named after the hash of what it holds; the page asks for nothing else, from nowhere else.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from page_parts import ROOT, PartMissing, build_msgspec, fetch_pyodide, find_python, read_lock

SOURCE = ROOT / "src" / "understudy"
BUILT = SOURCE / "ui" / "web" / "static"
LEFT_OUT = (
    "testing", "spi.py", "__main__.py", "ui/cli", "ui/terminal", "ui/notebook", "ui/web/static", "ui/web/app.py",
    "ui/web/drive_app.py", "ui/web/recording_app.py", "ui/web/sockets.py", "ui/web/camera_route.py",
    "ui/web/access.py", "addons/bridges",
)  # fmt: skip
"""What a page cannot use: other interfaces, the servers of this one, and bridges to other packages."""
ARCHIVE = "understudy.zip"
CHANGED = (1980, 1, 1, 0, 0, 0)
"""The date of all files in the archive, so that the same source gives the same bytes."""
COMPILE = """
import compileall, py_compile, sys
mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
sys.exit(not compileall.compile_dir(sys.argv[1], quiet=1, legacy=True, optimize=1, stripdir=sys.argv[1],
                                    invalidation_mode=mode))
"""
FOR_COMPILERS = (".pyi", ".h", ".a", ".pxd", ".c", ".pyx")
MOST_GZIP = 12e6
"""The most bytes that a visitor loads, by gzip."""


def main(target: Path) -> None:
    """Write all files into a folder, in place of what an earlier run wrote."""
    lock = read_lock()
    pyodide = fetch_pyodide(lock["pyodide"])
    python = find_python(str(lock["pyodide"]["python"]))
    msgspec = build_msgspec(lock, python, pyodide)
    if not (BUILT / "index.html").is_file():
        raise PartMissing("the page is not built: run make page")
    if target.exists() and not (target / "index.html").is_file():
        raise PartMissing(f"{target} is there already, and no page: give another folder")
    with TemporaryDirectory(dir=target.absolute().parent) as place:
        made = Path(place) / "site"
        parts = made / "parts"
        parts.mkdir(parents=True)
        for name in lock["pyodide"]["files"]:
            if name.endswith(".whl"):
                _copy_wheel(pyodide / name, parts / name)
            else:
                shutil.copy(pyodide / name, parts / name)
        _write_package_list(parts / "pyodide-lock.json")
        pack([(SOURCE, "understudy"), (msgspec, "msgspec")], parts / ARCHIVE, python)
        name = f"parts-{_hash_folder(parts)}"
        parts.rename(made / name)
        shutil.copytree(BUILT / "assets", made / "assets")
        shutil.copy(BUILT / "icon.svg", made)
        page = (BUILT / "index.html").read_text()
        meta = f'<meta name="understudy-parts" content="./{name}/" />'
        (made / "index.html").write_text(page.replace("<title>", f"{meta}\n    <title>", 1))
        shutil.rmtree(target, ignore_errors=True)
        made.rename(target)
    _report(target)


def pack(packages: list[tuple[Path, str]], archive: Path, python: Path) -> None:
    """Pack packages as bytecode, which is imported in half the time of its source."""
    with TemporaryDirectory() as place:
        for folder, name in packages:
            left_out = {folder / each for each in LEFT_OUT} if name == "understudy" else set()

            def ignore(where: str, names: list[str], left_out: set[Path] = left_out) -> set[str]:
                return {each for each in names if each == "__pycache__" or Path(where, each) in left_out}

            shutil.copytree(folder, Path(place, name), ignore=ignore)
        subprocess.run([str(python), "-c", COMPILE, place], check=True)
        with ZipFile(archive, "w", ZIP_DEFLATED, compresslevel=9) as packed:
            for path in sorted(Path(place).rglob("*")):
                if path.is_file() and path.suffix not in (".py", ".pyi"):
                    member = ZipInfo(path.relative_to(place).as_posix(), CHANGED)
                    member.compress_type = ZIP_DEFLATED
                    packed.writestr(member, path.read_bytes())


def _copy_wheel(wheel: Path, target: Path) -> None:
    """Copy a wheel without what is only for compilers and tests."""
    with ZipFile(wheel) as whole, ZipFile(target, "w", ZIP_DEFLATED, compresslevel=9) as copy:
        for member in whole.infolist():
            path = Path(member.filename)
            if path.suffix not in FOR_COMPILERS and not {"f2py", "tests"} & set(path.parts):
                copy.writestr(member, whole.read(member), ZIP_DEFLATED)


def _write_package_list(path: Path) -> None:
    """Leave in Pyodide's list of packages only those that lie beside it, as they are there."""
    listed, packages = json.loads(path.read_text()), {}
    for name, package in listed["packages"].items():
        file = path.parent / package["file_name"]
        if file.is_file():
            packages[name] = package | {"sha256": hashlib.sha256(file.read_bytes()).hexdigest()}
    path.write_text(json.dumps(listed | {"packages": packages}))


def _hash_folder(folder: Path) -> str:
    whole = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        whole.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return whole.hexdigest()[:12]


def _report(target: Path) -> None:
    """Say how much a visitor loads; exit with 1 if that is more than was promised."""
    files = [path for path in sorted(target.rglob("*")) if path.is_file()]
    raw = sum(path.stat().st_size for path in files)
    packed = sum(len(gzip.compress(path.read_bytes(), 6)) for path in files)
    sys.stdout.write(f"{target}: {len(files)} files, {raw / 1e6:.1f} MB, {packed / 1e6:.1f} MB by gzip\n")
    if packed > MOST_GZIP:
        sys.exit(f"a visitor would load more than {MOST_GZIP / 1e6:.0f} MB: leave something out")


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]))
    except PartMissing as error:
        sys.stderr.write(f"The page without a server is not built: {error}.\n")
        sys.exit(2)
