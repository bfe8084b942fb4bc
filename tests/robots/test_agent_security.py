"""Agents over TLS: who has no certificate of the team is not heard, nor is who must not give orders."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
if shutil.which("openssl") is None:
    pytest.skip("needs openssl", allow_module_level=True)

from tests.robots.routers import free_port
from tests.waiting import BOUND_S, wait_until

from understudy.addons.robots.ros.transport import Unreachable
from understudy.addons.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions
from understudy.errors import UnderstudyError

DOCS = Path(__file__).parents[2] / "docs"
TEAM = "patrol"
REPORT = "report/patrol_0"
TRIES_S = 1.0
"""For so long who must not be heard tries at least to connect and to send; each try takes a tenth of it."""
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
def join_networks(listening: Mapping[str, Any], *others: Mapping[str, Any]) -> Iterator[list[ZenohNetwork]]:
    """One that listens, and others that connect to it; each by its configuration."""
    with ExitStack() as ends:
        address = f"127.0.0.1:{free_port()}"
        first = ZenohOptions(listen=[f"tls/{address}"], multicast=False, config=listening)
        made = [ZenohNetwork(TEAM, first)]
        ends.callback(made[0].close)
        for config in others:
            used = "tls" if config else "tcp"
            made.append(
                ZenohNetwork(
                    TEAM, ZenohOptions(connect=[f"{used}/{address}"], multicast=False, config=config)
                )
            )
            ends.callback(made[-1].close)
        yield made


def wait_heard(receiver: ZenohNetwork, sender: ZenohNetwork, key: str) -> None:
    """Wait until a message of a key arrives."""
    inbox = receiver.listen(key)

    def is_heard() -> bool:
        sender.publish(key, b"go")
        time.sleep(0.01)
        return bool(inbox.take_all())

    wait_until(is_heard)


def hears(receiver: ZenohNetwork, sender: ZenohNetwork, key: str) -> bool:
    """Whether messages of a key arrive, as a report does that is sent after them over the same link."""
    inbox, reports = receiver.listen(key), receiver.listen(REPORT)

    def is_reported(text: bytes) -> bool:
        sender.publish(key, b"go")
        sender.publish(REPORT, text)
        time.sleep(0.01)
        return text in reports.take_all()

    wait_until(lambda: is_reported(b"since then, who listens is known"))
    wait_until(lambda: is_reported(b"these have come after it"))
    return bool(inbox.take_all())


OBEYED = [  # an agent, whether a robot obeys its orders, is driven by it, and answers it
    ("pioneer_2", False, False, False),
    ("patrol_0", True, False, False),
    ("laptop", False, True, True),
]


@pytest.mark.timed
@pytest.mark.parametrize(("name", "orders", "drives", "asks"), OBEYED)
def test_only_who_may_give_orders_or_ask_is_heard(
    certificates: Path, name: str, orders: bool, drives: bool, asks: bool
) -> None:
    """And all who are of the team are watched, and see who claims or holds a name."""
    mine, theirs = (read_documented(certificates, each) for each in ("pioneer_1", name))
    with join_networks(mine, theirs) as (robot, other):
        wait_heard(other, robot, "status/pioneer_1")
        wait_heard(other, robot, "view/pioneer_1")
        robot.declare_token("claim/pioneer_1/7")
        robot.answer("claim/pioneer_1/7", lambda question: b"")
        robot.declare_token("held/pioneer_1")
        wait_until(lambda: len(other.list_tokens("claim/pioneer_1/*")) == 1)
        wait_until(lambda: len(other.list_tokens("held/*")) == 1)
        assert other.ask("claim/pioneer_1/*", b"", timeout_s=BOUND_S) == {"claim/pioneer_1/7": b""}
        assert hears(robot, other, "order/patrol_0") == orders
        assert hears(robot, other, "drive/pioneer_1") == drives
        robot.answer("agent/pioneer_1", lambda question: b"yes")
        if asks:
            wait_until(lambda: other.ask("agent/*", b"status") == {"agent/pioneer_1": b"yes"})
        else:
            assert other.ask("agent/*", b"status") == {}


@pytest.mark.timed
def test_who_has_no_certificate_of_the_team_is_not_heard(certificates: Path) -> None:
    """While those who have one hear each other."""
    trusting = {"transport/link/tls/root_ca_certificate": str(certificates / "team.pem")}
    client = {"mode": "client", "listen/endpoints": []}  # which needs no certificate to listen with
    strangers: list[Mapping[str, Any]] = [make_tls(certificates, "stranger") | trusting, {}]
    with pytest.raises(Unreachable), join_networks(make_tls(certificates, "pioneer_1"), trusting | client):
        pass
    certified = (make_tls(certificates, each) for each in ("pioneer_1", "patrol_0"))
    with join_networks(*certified, *strangers) as (robot, leader, *others):
        leader.announce("patrol_0")
        for each in others:
            each.announce("stranger")
        orders, reports, until = (
            robot.listen("order/patrol_0"),
            leader.listen(REPORT),
            time.monotonic() + TRIES_S,
        )
        heard, reported = list[bytes](), False

        def are_heard() -> bool:
            nonlocal reported
            leader.publish("order/patrol_0", b"leader")
            robot.publish(REPORT, b"robot")
            for each in others:
                each.publish("order/patrol_0", b"stranger")
            time.sleep(0.01)
            heard.extend(orders.take_all())
            reported = reported or bool(reports.take_all())
            return bool(heard) and reported and "patrol_0" in robot.present and time.monotonic() > until

        wait_until(are_heard)
        assert {*heard} == {b"leader"}
        assert robot.present == {"patrol_0"}


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
