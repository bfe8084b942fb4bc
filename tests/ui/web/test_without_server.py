"""The studio where there is no web server: no sockets, no processes and no threads, as in a page of a browser."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

SCRIPT = """
import asyncio, json, os, subprocess, sys, threading, time
from importlib.abc import MetaPathFinder
from pathlib import Path

MISSING = {"starlette", "uvicorn", "websockets", "multiprocessing", "_multiprocessing", "typer"}

class Missing(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name.partition(".")[0] in MISSING:
            raise ModuleNotFoundError(f"there is no {name} here")
        return None

sys.meta_path.insert(0, Missing())
del threading.get_native_id, time.thread_time

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.ui.controller.beside import make_immediate
from understudy.ui.web import export_zip, library_zip
from understudy.ui.web.file_requests import FileRequest, answer_safely
from understudy.ui.web.server import StudioServer
from understudy.ui.web.session_host import SessionHost

def refuse(*_, **__):
    raise RuntimeError("can't start new thread")

threading.Thread.start = refuse
subprocess.Popen.__init__ = refuse
scenario = find_scenario("forage")
host = SessionHost(scenario, Path(sys.argv[1]), make_scenario_kit(scenario), beside=make_immediate())
studio = StudioServer(host)
page = studio.connect(None)

def ask(number, **message):
    studio.handle_text(page, json.dumps({"id": number, **message}))
    studio.run_due_ticks()
    while (queued := page.next()) is not None:
        if not queued[1] and (answer := json.loads(queued[0])).get("re") == number:
            return answer

async def no_content():
    for chunk in ():
        yield chunk

async def zip_library():
    reply = await library_zip.transfer_library(studio, FileRequest(False, [], no_content()))
    query = [("name", "goto"), ("to", "c99"), ("bind", "A=station")]
    export = await answer_safely(lambda: export_zip.export_as_zip(host, FileRequest(True, query, no_content())))
    async def give():
        yield reply.content
    query = [("key", page.key)]
    taken = await answer_safely(lambda: library_zip.transfer_library(studio, FileRequest(True, query, give())))
    return reply.content[:2].decode(), export.content[:2].decode(), taken.content.decode()

goto = {"do": "new", "name": "goto", "states": ["forward", "rotate_left", "rotate_right"], "live": True,
        "features": ["distance_to(A)", "angle_to(A)"], "parameters": ["A"],
        "flags": ["done"], "targets": {"A": "station"}}
messages = [goto, {"do": "press", "state": "forward"}, {"do": "step"}, {"do": "request_advice"}, {"do": "save"},
            {"do": "evaluate", "count": 100}, {"do": "rerun_failures"}]
answers = [ask(number, **message) for number, message in enumerate(messages)]
print(json.dumps({"answers": answers, "score": host.session_data().score.text, "zips": asyncio.run(zip_library()),
                  "threads": threading.active_count()}))
"""


def test_teaches_saves_and_exports_without_sockets_processes_and_threads(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path / "library")],
        env={**os.environ, "UNDERSTUDY_KERNELS": "python"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    *taught, evaluated, rerun = result["answers"]
    assert [each.get("error", "") for each in taught] == [""] * len(taught)
    assert evaluated["error"] == "worlds cannot be run beside this one here"
    assert "no folder of failing worlds" in rerun["error"]
    assert result["score"] == "not measured: worlds cannot be run beside this one here"
    assert result["zips"] == ["PK", "PK", '{"message":"The zip contains nothing new"}']
    assert result["threads"] == 1
    assert (tmp_path / "library" / "goto.json").is_file()
