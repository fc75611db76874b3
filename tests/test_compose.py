"""docker-compose.yml starts the rows of services/processes.py, and exposes nothing."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from services.processes import HUB, PROCESSES

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def containers() -> dict[str, dict[str, Any]]:
    services: dict[str, dict[str, Any]] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())[
        "services"
    ]
    return services


def test_services_are_the_rows_of_the_process_table(containers: dict[str, dict[str, Any]]) -> None:
    assert list(containers) == [row.name for row in PROCESSES]


def test_every_container_runs_the_module_of_its_row(containers: dict[str, dict[str, Any]]) -> None:
    for row in PROCESSES:
        started = f"python -m {row.module} --robot icub:reach "
        assert containers[row.name]["command"].startswith(started)


def test_all_share_one_image_and_end_at_once_on_a_signal(
    containers: dict[str, dict[str, Any]],
) -> None:
    assert {container["image"] for container in containers.values()} == {"ulna"}
    assert all(container["init"] is True for container in containers.values())


def test_only_the_hub_listens_and_no_port_leaves_the_compose_network(
    containers: dict[str, dict[str, Any]],
) -> None:
    for name, container in containers.items():
        assert "ports" not in container
        end = "--listen tcp/0.0.0.0:7447" if name == HUB.name else "--hub tcp/hub:7447"
        assert end in container["command"]


def test_dockerfile_needs_no_registry_but_the_base_image() -> None:
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    assert not any(line.startswith("# syntax=") for line in lines)
    assert [line for line in lines if line.startswith("FROM ")] == ["FROM python:3.11-slim"]
