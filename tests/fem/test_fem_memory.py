"""Memory that is left: the machine's, that of control groups of either version, and what is said."""

from __future__ import annotations

import resource

import pytest

from tedm_cli.errors import UsageError
from tedm_cli.memory import available_bytes

GB = 10**9


@pytest.fixture(autouse=True)
def nothing_said(monkeypatch):
    monkeypatch.delenv("TEDM_MEMORY_GB", raising=False)
    unlimited = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
    monkeypatch.setattr(resource, "getrlimit", lambda kind: unlimited)


def machine(root, files):
    for name, text in {"proc/meminfo": "MemTotal: 64 kB\nMemAvailable:   16000000 kB\n", **files}.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root


GROUP = "sys/fs/cgroup/jobs/one"


@pytest.mark.parametrize(
    ("files", "left"),
    [
        pytest.param({}, 16_384_000_000, id="the machine"),
        pytest.param(
            {
                "proc/self/cgroup": "0::/jobs/one\n",
                f"{GROUP}/memory.max": f"{8 * GB}\n",
                f"{GROUP}/memory.current": f"{3 * GB}\n",
                f"{GROUP}/memory.stat": f"anon 5\ninactive_file {GB}\nactive_file 7\n",
            },
            6 * GB,
            id="its group, whose idle cache is free",
        ),
        pytest.param(
            {
                "proc/self/cgroup": "0::/jobs/one\n",
                f"{GROUP}/memory.max": "max\n",
                f"{GROUP}/memory.current": f"{3 * GB}\n",
                "sys/fs/cgroup/jobs/memory.max": f"{4 * GB}\n",
                "sys/fs/cgroup/jobs/memory.current": f"{3 * GB}\n",
            },
            GB,
            id="the group above",
        ),
        pytest.param(
            {
                "proc/self/cgroup": "7:cpu,cpuacct:/other\n4:memory:/job\n",
                "sys/fs/cgroup/memory/job/memory.limit_in_bytes": f"{2 * GB}\n",
                "sys/fs/cgroup/memory/job/memory.usage_in_bytes": f"{GB // 2}\n",
                "sys/fs/cgroup/memory/memory.limit_in_bytes": "9223372036854771712\n",
                "sys/fs/cgroup/memory/memory.usage_in_bytes": f"{5 * GB}\n",
            },
            3 * GB // 2,
            id="version 1",
        ),
    ],
)
def test_what_is_left(tmp_path, files, left):
    assert available_bytes(machine(tmp_path, files)) == left


def test_a_container_sees_its_own_group_as_the_root(tmp_path):
    files = {
        "proc/self/cgroup": "0::/\n",
        "sys/fs/cgroup/memory.max": f"{2 * GB}\n",
        "sys/fs/cgroup/memory.current": f"{GB}\n",
    }
    assert available_bytes(machine(tmp_path, files)) == GB


def test_a_limit_of_the_shell(tmp_path, monkeypatch):
    limit = (3 * GB, resource.RLIM_INFINITY)
    monkeypatch.setattr(resource, "getrlimit", lambda kind: limit if kind == resource.RLIMIT_AS else None)
    found = available_bytes(machine(tmp_path, {"proc/self/statm": "1000 500 100 0 0 0 0\n"}))
    assert found == 3 * GB - 1000 * resource.getpagesize()


def test_a_system_that_tells_nothing(tmp_path):
    assert available_bytes(tmp_path) is None


def test_what_is_said_counts(tmp_path, monkeypatch):
    monkeypatch.setenv("TEDM_MEMORY_GB", "2.5")
    assert available_bytes(machine(tmp_path, {})) == 2_500_000_000
    for wrong in ("", "much", "-1", "0", "nan", "inf"):
        monkeypatch.setenv("TEDM_MEMORY_GB", wrong)
        with pytest.raises(UsageError, match="environment: TEDM_MEMORY_GB is"):
            available_bytes()
