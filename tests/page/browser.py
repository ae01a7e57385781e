"""Headless Chromium, driven over its debugging pipe. It needs only Python and Chromium."""

import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --disable-dev-shm-usage --disable-extensions "
    "--remote-debugging-pipe --window-size=1400,900"
).split()
# Instead of --disable-gpu, for pages that draw with WebGL.
WEBGL_FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


class BrowserError(Exception):
    pass


class Browser:
    """One page in a browser with a separate profile. Records messages of the console and the network."""

    def __init__(self):
        program = next(filter(None, map(shutil.which, NAMES)), None)
        if not program:
            raise BrowserError("Chromium is not installed: apt-get install chromium")
        self.profile = tempfile.mkdtemp(prefix="recurse-page-test-")
        self.complaints, self.requests = [], []
        self.count, self.buffer, self.session = 0, b"", None
        # The browser reads descriptor 3 and writes 4: both are reserved, so that pipes get different ones.
        taken = [os.open(os.devnull, os.O_RDONLY) for _ in range(10)]
        commandRead, self.commands = self.highPipe()
        self.answers, answerWrite = self.highPipe()

        def connect():
            os.dup2(commandRead, 3)
            os.dup2(answerWrite, 4)

        self.log = open(os.path.join(self.profile, "log"), "w+b")
        self.process = subprocess.Popen(
            [program, *FLAGS, "--user-data-dir=" + self.profile, "about:blank"],
            stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log, close_fds=False, preexec_fn=connect)
        for descriptor in (commandRead, answerWrite, *taken):
            os.close(descriptor)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")

    @staticmethod
    def highPipe():
        ends = os.pipe()
        high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 20) for end in ends]
        for end in ends:
            os.close(end)
        return high

    def close(self):
        self.process.kill()
        self.process.wait()
        self.log.close()
        shutil.rmtree(self.profile, ignore_errors=True)

    def call(self, method, **parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive(method)
            if answer.get("id") == self.count:
                if "error" in answer:
                    raise BrowserError(f"{method}: {answer['error']}")
                return answer["result"]
            self.notice(answer)

    def receive(self, purpose, seconds=60):
        while b"\0" not in self.buffer:
            ready, _, _ = select.select([self.answers], [], [], seconds)
            data = os.read(self.answers, 1 << 20) if ready else b""
            if not data:
                self.log.seek(0)
                raise BrowserError(f"no answer to {purpose}\n{self.log.read().decode(errors='replace')[-2000:]}")
            self.buffer += data
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def notice(self, event):
        method, data = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(data["exceptionDetails"])[:500])
        elif method == "Runtime.consoleAPICalled" and data["type"] in ("error", "warning", "assert"):
            self.complaints.append(json.dumps(data["args"])[:500])
        elif method == "Log.entryAdded" and data["entry"]["level"] in ("error", "warning"):
            self.complaints.append(data["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(data["request"]["url"])

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise BrowserError(f"{expression}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def open(self, file, readyWhen, seconds=60):
        self.openUrl("file://" + os.path.abspath(file), readyWhen, seconds)

    def openUrl(self, url, readyWhen, seconds=60):
        self.complaints, self.requests = [], []
        self.call("Page.navigate", url=url)
        end = time.monotonic() + seconds
        while not self.evaluate(f"document.readyState === 'complete' && !!({readyWhen})"):
            if time.monotonic() > end:
                raise BrowserError(f"{url} does not get ready: {self.complaints}")
            time.sleep(0.05)

    def settle(self):
        """Waits until the requested changes have been drawn."""
        self.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def clickAt(self, x, y):
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
        self.settle()

    def click(self, element):
        """Clicks with the mouse into the middle of an element, given as a JavaScript expression."""
        box = self.evaluate(f"(() => {{ const e = {element}; e.scrollIntoView({{block: 'nearest'}});"
                            "const b = e.getBoundingClientRect();"
                            "return [b.left + b.width / 2, b.top + b.height / 2]; })()")
        self.clickAt(*box)

    def key(self, key, code="", shift=False):
        text = {"text": key} if len(key) == 1 else {}
        modifiers = 8 if shift else 0
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=code, modifiers=modifiers, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code, modifiers=modifiers)
        self.settle()
