"""A page in headless Chromium, driven over the pipe of its debugging protocol."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--remote-debugging-pipe", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip


def chromium() -> str | None:
    """The browser of this machine, or None."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    return next((found for found in map(shutil.which, names) if found), None)


class Browser:
    """One browser with one page, in a folder of its own that is gone afterwards."""

    def __init__(self, *more: str) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="tedm-chromium-", ignore_cleanup_errors=True)
        self.number = 0
        self.events: list[dict[str, Any]] = []
        self.rest = b""
        command = [str(chromium()), *FLAGS, *more, f"--user-data-dir={self.folder.name}", "about:blank"]
        to_child, self.write_end = os.pipe()
        self.read_end, from_child = os.pipe()

        # The protocol is spoken on the file descriptors 3 and 4 of the browser.
        shell = f'exec 3<&{to_child} 4>&{from_child}; exec "$@"'
        self.process = subprocess.Popen(
            ["/bin/bash", "-c", shell, "chromium", *command],
            pass_fds=(to_child, from_child),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_child)
        os.close(from_child)
        self.session = ""
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to one command; what happens meanwhile is kept in `events`."""
        self.number += 1
        message: dict[str, Any] = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write_end, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self.number:
                assert "error" not in answer, answer
                return dict(answer["result"])
            self.events.append(answer)

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self.rest:
            part = os.read(self.read_end, 1 << 20)
            assert part, "the browser is gone"
            self.rest += part
        head, self.rest = self.rest.split(b"\0", 1)
        return dict(json.loads(head))

    def size(self, width: int, height: int, *, phone: bool = False, dark: bool = False, scale: float = 1) -> None:
        self.send(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=phone
        )
        self.send("Emulation.setTouchEmulationEnabled", enabled=phone)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.send("Emulation.setEmulatedMedia", features=[scheme])

    def open(self, path: Path, until: str, seconds: float = 60.0) -> None:
        """Load a file, and wait until an expression is true."""
        self.send("Page.navigate", url=path.resolve().as_uri())
        self.wait(until, seconds)

    def wait(self, until: str, seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not self.value(f"(() => {{ try {{ return Boolean({until}); }} catch {{ return false; }} }})()"):
            assert time.monotonic() < end, f"never came true: {until}; {self.faults()}"
            time.sleep(0.05)

    def value(self, expression: str) -> Any:
        """What an expression is in the page; a promise is waited for."""
        answer = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def faults(self) -> list[str]:
        """What the page complained of, and what it tried to fetch beside itself."""
        found = []
        for event in self.events:
            method, more = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                found.append(str(more["exceptionDetails"].get("exception", more["exceptionDetails"])))
            elif method == "Log.entryAdded" and more["entry"]["level"] in ("error", "warning"):
                found.append(more["entry"]["text"])
            elif method == "Runtime.consoleAPICalled" and more["type"] in ("error", "warning"):
                found.append(str(more["args"]))
            elif method == "Network.requestWillBeSent" and not more["request"]["url"].startswith(
                ("file:", "data:", "blob:", "about:")
            ):
                found.append(more["request"]["url"])
        return found

    def key(self, name: str) -> None:
        for kind in ("keyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key=name, code=name)

    def screenshot(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"]))

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, at: TracebackType | None) -> None:
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
        os.close(self.write_end)
        os.close(self.read_end)
        self.folder.cleanup()
