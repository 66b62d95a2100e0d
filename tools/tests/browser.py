"""A headless Chromium, by its own protocol over a pipe: nothing but Python's library is needed."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Optional

NAMES = ("chromium", "chromium-browser", "google-chrome")


def found() -> Optional[str]:
    return next((path for path in map(shutil.which, NAMES) if path), None)


def _high(descriptor: int) -> int:
    """Out of the way of 3 and 4"""
    made = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, 20)
    os.close(descriptor)
    return made


class Browser:
    """One page at a time.  `errors`: what its console and its scripts have complained of"""

    def __enter__(self) -> Browser:
        self._folder = tempfile.TemporaryDirectory(prefix="kalmanq-browser", ignore_cleanup_errors=True)
        commands, self._writes = map(_high, os.pipe())
        self._reads, answers = map(_high, os.pipe())
        self._process = subprocess.Popen(
            [str(found()), "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--hide-scrollbars", f"--user-data-dir={self._folder.name}", "--remote-debugging-pipe", "about:blank"],
            preexec_fn=lambda: (os.dup2(commands, 3), os.dup2(answers, 4)),  # where Chromium expects them
            close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(commands), os.close(answers)
        self._count, self._left, self.errors, self._session = 0, b"", [], None
        target = next(one for one in self._call("Target.getTargets")["targetInfos"] if one["type"] == "page")
        self._session = self._call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")
        self._call("Browser.setDownloadBehavior", session=False, behavior="allow", downloadPath=self._folder.name)
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._writes), os.close(self._reads)
        self._folder.cleanup()

    def _call(self, method: str, session: bool = True, **given: Any) -> Any:
        self._count += 1
        message = {"id": self._count, "method": method, "params": given}
        if session and self._session:
            message["sessionId"] = self._session
        os.write(self._writes, json.dumps(message).encode() + b"\0")
        while True:
            heard = self._heard()
            if heard.get("id") == self._count:
                if "error" in heard:
                    raise RuntimeError(f"{method}: {heard['error']['message']}")
                return heard["result"]

    def _heard(self) -> Any:
        while b"\0" not in self._left:
            if not select.select([self._reads], [], [], 60)[0]:
                raise TimeoutError("the browser says nothing")
            more = os.read(self._reads, 1 << 20)
            if not more:
                raise EOFError("the browser has ended")
            self._left += more
        one, _, self._left = self._left.partition(b"\0")
        heard = json.loads(one)
        if heard.get("method") == "Runtime.exceptionThrown":
            of = heard["params"]["exceptionDetails"]
            self.errors.append(of.get("exception", {}).get("description") or of["text"])
        if heard.get("method") == "Runtime.consoleAPICalled" and heard["params"]["type"] in ("error", "warning"):
            self.errors.append(str(heard["params"]["args"]))
        if heard.get("method") == "Log.entryAdded" and heard["params"]["entry"]["level"] in ("error", "warning"):
            self.errors.append(heard["params"]["entry"]["text"])
        return heard

    def open(self, path: Path, width: int = 1200, height: int = 900, dark: bool = False) -> None:
        self.look(width, height, dark)
        self._call("Page.navigate", url=Path(path).resolve().as_uri())
        self.wait("document.readyState === 'complete'")

    def look(self, width: int, height: int, dark: bool = False) -> None:
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        self._call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def run(self, script: str) -> Any:
        """Of an expression, or of a promise"""
        made = self._call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in made:
            raise RuntimeError(made["exceptionDetails"].get("exception", {}).get("description", "a script has failed"))
        return made["result"].get("value")

    def wait(self, condition: str, seconds: float = 20) -> None:
        ends = time.monotonic() + seconds
        while not self.run(condition):
            if time.monotonic() > ends:
                raise TimeoutError(f"{condition}; errors: {self.errors}")
            time.sleep(0.02)

    def drag(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        def mouse(kind: str, at: tuple[float, float], buttons: int) -> None:
            self._call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], button="left", buttons=buttons, clickCount=1)
        mouse("mouseMoved", begin, 0), mouse("mousePressed", begin, 1)
        mouse("mouseMoved", end, 1), mouse("mouseReleased", end, 0)

    def key(self, name: str, modifiers: int = 0) -> None:
        codes = {"End": 35, "Home": 36, "z": 90}
        for kind in ("rawKeyDown", "keyUp"):
            self._call("Input.dispatchKeyEvent", type=kind, key=name, code=name, windowsVirtualKeyCode=codes[name], modifiers=modifiers)

    @contextmanager
    def beginning_with(self, script: str) -> Iterator[None]:
        """What each page that is opened runs first"""
        made = self._call("Page.addScriptToEvaluateOnNewDocument", source=script)
        try:
            yield
        finally:
            self._call("Page.removeScriptToEvaluateOnNewDocument", identifier=made["identifier"])

    def accessible(self) -> list[dict[str, Any]]:
        return self._call("Accessibility.getFullAXTree")["nodes"]

    def picture(self, path: Path) -> None:
        size = self._call("Page.getLayoutMetrics")["cssContentSize"]
        made = self._call("Page.captureScreenshot", captureBeyondViewport=True, clip={"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1})
        Path(path).write_bytes(base64.b64decode(made["data"]))
