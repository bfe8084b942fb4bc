"""Agents over TLS: who has no certificate of the team is not heard, nor is who must not give orders."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
if shutil.which("openssl") is None:
    pytest.skip("needs openssl", allow_module_level=True)

from tests.robots.routers import free_port
from tests.robots.test_zenoh_network import wait_until

from understudy.errors import UnderstudyError
from understudy.robots.ros.transport import Unreachable
from understudy.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions
from understudy.runtime.agents.network import Inbox

DOCS = Path(__file__).parents[2] / "docs"
TEAM = "patrol"
HEARD_S = 3.0
"""For so long who must not be heard goes on sending; the others are heard after a small part of it."""
DOCUMENTED = "/etc/understudy/"
"""Where the certificates are in the example of the documents."""


def run_openssl(*arguments: str, where: Path) -> None:
    subprocess.run(["openssl", *arguments], cwd=where, check=True, capture_output=True)


def make_authority(name: str, folder: Path) -> None:
    """Make the key and the certificate of an authority."""
    run_openssl(
        "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
        "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.pem", where=folder,
    )  # fmt: skip


def make_certificate(name: str, folder: Path, *, authority: str) -> None:
    """Make the key and the certificate of an agent, with its name in it."""
    run_openssl(
        "req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", f"/CN={name}",
        "-keyout", f"{name}.key", "-out", f"{name}.csr", where=folder,
    )  # fmt: skip
    (folder / "extensions").write_text(
        "basicConstraints=CA:FALSE\nextendedKeyUsage=serverAuth,clientAuth\nsubjectAltName=IP:127.0.0.1\n"
    )
    run_openssl(
        "x509", "-req", "-in", f"{name}.csr", "-CA", f"{authority}.pem", "-CAkey", f"{authority}.key",
        "-CAcreateserial", "-days", "2", "-extfile", "extensions", "-out", f"{name}.pem", where=folder,
    )  # fmt: skip


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The certificates of three agents of the team, and of one that another authority has signed."""
    folder = tmp_path_factory.mktemp("certificates")
    for authority, names in {
        "team": ("patrol_0", "pioneer_1", "pioneer_2", "laptop"),
        "other": ("stranger",),
    }.items():
        make_authority(authority, folder)
        for name in names:
            make_certificate(name, folder, authority=authority)
    return folder


def read_documented(folder: Path, name: str) -> dict[str, Any]:
    """Read the example of docs/agents.md, with the certificates of one agent."""
    blocks = re.findall(r"```toml\n(.*?)```", (DOCS / "agents.md").read_text(), re.DOTALL)
    example = next(block for block in blocks if "access_control" in block)
    here = example.replace(f"{DOCUMENTED}agent", str(folder / name)).replace(DOCUMENTED, f"{folder}/")
    config: dict[str, Any] = tomllib.loads(here)["agents"]["network"]["config"]
    return config


def make_tls(folder: Path, name: str) -> dict[str, Any]:
    """Make the part of it for TLS alone."""
    return {key: value for key, value in read_documented(folder, name).items() if key != "access_control"}


@contextmanager
def two(
    one: Mapping[str, Any], other: Mapping[str, Any], *, protocol: str = "tls"
) -> Iterator[tuple[ZenohNetwork, ZenohNetwork]]:
    """One that listens, and another that connects to it."""
    port = free_port()
    first = ZenohNetwork(TEAM, ZenohOptions(listen=[f"tls/127.0.0.1:{port}"], multicast=False, config=one))
    try:
        second = ZenohNetwork(
            TEAM,
            ZenohOptions(
                connect=[f"{protocol}/127.0.0.1:{port}"],
                multicast=False,
                config=other,
            ),
        )
        try:
            yield first, second
        finally:
            second.close()
    finally:
        first.close()


def hears(inbox: Inbox, sender: ZenohNetwork, key: str) -> bool:
    until = time.monotonic() + HEARD_S
    while time.monotonic() < until:
        sender.publish(key, b"go")
        time.sleep(0.05)
        if inbox.take_all():
            return True
    return False


def test_agents_with_certificates_of_the_team_hear_each_other(certificates: Path) -> None:
    with two(make_tls(certificates, "pioneer_1"), make_tls(certificates, "patrol_0")) as (robot, leader):
        leader.announce("patrol_0")
        wait_until(lambda: "patrol_0" in robot.present)
        assert hears(robot.listen("order/patrol_0"), leader, "order/patrol_0")
        assert hears(leader.listen("report/patrol_0"), robot, "report/patrol_0")


def test_who_has_no_certificate_of_the_team_is_not_heard(certificates: Path) -> None:
    mine = make_tls(certificates, "pioneer_1")
    trusting = {"transport/link/tls/root_ca_certificate": str(certificates / "team.pem")}
    client = {"mode": "client", "listen/endpoints": []}  # which needs no certificate to listen with
    strangers = {
        "none": ("tls", trusting | client),
        "another": ("tls", make_tls(certificates, "stranger") | trusting),
        "no TLS": ("tcp", {}),
    }
    for what, (protocol, theirs) in strangers.items():
        with suppress(Unreachable), two(mine, theirs, protocol=protocol) as (robot, stranger):
            stranger.announce("patrol_0")
            assert not hears(robot.listen("order/patrol_0"), stranger, "order/patrol_0"), what
            assert not robot.present, what


def test_who_must_not_give_orders_is_not_heard(certificates: Path) -> None:
    mine = read_documented(certificates, "pioneer_1")
    for name, obeyed in {"pioneer_2": False, "patrol_0": True}.items():
        with two(mine, read_documented(certificates, name)) as (robot, other):
            assert hears(robot.listen("report/patrol_0"), other, "report/patrol_0")
            assert hears(robot.listen("order/patrol_0"), other, "order/patrol_0") == obeyed, name


@pytest.mark.parametrize(("name", "obeyed"), [("pioneer_2", False), ("laptop", True)])
def test_only_operators_train(certificates: Path, name: str, obeyed: bool) -> None:
    """And all who are of the team are watched, and see who claims or holds a name."""
    mine = read_documented(certificates, "pioneer_1")
    with two(mine, read_documented(certificates, name)) as (robot, other):
        assert hears(other.listen("status/*"), robot, "status/pioneer_1")
        assert hears(other.listen("view/pioneer_1"), robot, "view/pioneer_1")
        robot.declare_token("claim/pioneer_1/7")
        robot.answer("claim/pioneer_1/7", lambda question: b"")
        robot.declare_token("held/pioneer_1")
        wait_until(lambda: len(other.list_tokens("claim/pioneer_1/*")) == 1)
        wait_until(lambda: len(other.list_tokens("held/*")) == 1)
        assert other.ask("claim/pioneer_1/*", b"") == {"claim/pioneer_1/7": b""}
        assert hears(robot.listen("drive/pioneer_1"), other, "drive/pioneer_1") == obeyed


def test_only_operators_are_answered(certificates: Path) -> None:
    for name, answered in {"pioneer_2": {}, "laptop": {"agent/pioneer_1": b"yes"}}.items():
        mine, theirs = (read_documented(certificates, each) for each in ("pioneer_1", name))
        with two(mine, theirs) as (robot, other):
            robot.answer("agent/pioneer_1", lambda question: b"yes")
            assert hears(robot.listen("report/patrol_0"), other, "report/patrol_0")
            assert other.ask("agent/*", b"status") == answered, name


def test_a_certificate_that_is_not_there_is_named(certificates: Path) -> None:
    missing = make_tls(certificates, "nobody")
    with pytest.raises(UnderstudyError, match=r"cannot be joined: .*correct \[agents.network\]"):
        ZenohNetwork(
            TEAM, ZenohOptions(listen=[f"tls/127.0.0.1:{free_port()}"], multicast=False, config=missing)
        )


@pytest.mark.parametrize("config", [{"transport/link/tsl": True}, {"access_control": {"enabled": "maybe"}}])
def test_keys_that_zenoh_does_not_know_are_named(config: dict[str, Any]) -> None:
    with pytest.raises(UnderstudyError) as caught:
        ZenohNetwork(TEAM, ZenohOptions(multicast=False, config=config))
    assert next(iter(config)) in str(caught.value)
