"""One open page."""

from __future__ import annotations

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, Literal, Protocol, final
from weakref import WeakValueDictionary

from viser import ClientHandle, GuiApi, NotificationHandle, SceneApi

from spiraltrunk.design import TrunkDesign
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.studio.page.act_queue import ActQueue
from spiraltrunk.studio.page.job import SERIOUS, Job, Refusal, Work

Kind = Literal["error", "refusal", "warning", "done"]
"""Kinds of notices; a refusal is of what a person gave, and an error of what was under way."""

_COLORS: dict[Kind, tuple[int, int, int]] = {
    "error": (213, 94, 0), "refusal": (213, 94, 0), "warning": (230, 159, 0), "done": (0, 158, 115),
}  # fmt: skip
"""Colours of notices, of the palette of Okabe and Ito, that colour-blind people tell apart."""

_TITLES: dict[Kind, str] = {
    "error": "That did not work", "refusal": "Not accepted", "warning": "Note", "done": "Done"
}  # fmt: skip

_SHOWN = 8.0
"""Time after which a notice that needs no answer goes [s]."""

MOST_ERRORS = 3
"""Errors that are shown at a time; of more, the oldest goes [-]."""

_PATIENCE = 5.0
"""Time that a page's thread has to end [s]."""

_log = logging.getLogger("spiraltrunk")


class TextReader(Protocol):
    """A control of numbers that is told which text it got in the place of one."""

    def read_text(self, text: str) -> None:
        """Take or refuse the text; called in the page's thread."""


@final
class Page:
    """One open page: its controls, scene, design, and the work that it started.

    Everything that reacts to the person runs in one thread of the page, in order (`later`), so that tabs need no locks.
    """

    def __init__(self, client: ClientHandle, design: TrunkDesign) -> None:
        self.client = client
        self.gui: GuiApi = client.gui
        """Controls of this page alone."""
        self.scene: SceneApi = client.scene
        """Scene of this page alone."""
        self._design = design
        self._listeners: list[Callable[[TrunkDesign], None]] = []
        self._is_dark = False
        self._dark_listeners: list[Callable[[bool], None]] = []
        self._jobs: set[Job] = set()
        self._closing: list[Callable[[], None]] = []
        self._readers: WeakValueDictionary[str, TextReader] = WeakValueDictionary()
        self._queue = ActQueue(self.try_act)
        self._timers: dict[str, threading.Timer] = {}
        self._lock = threading.Lock()
        self._notices: OrderedDict[str, NotificationHandle] = OrderedDict()
        self.is_closed = False

    @property
    def design(self) -> TrunkDesign:
        """The design that all tabs show."""
        return self._design

    def set_design(self, design: TrunkDesign) -> None:
        """Change the design; every listener is called."""
        self._design = design
        for listener in self._listeners:
            listener(design)

    def on_design(self, listener: Callable[[TrunkDesign], None]) -> None:
        """Call ``listener`` with each new design."""
        self._listeners.append(listener)

    def set_dark(self, is_dark: bool) -> None:
        """Tell every listener whether the page's ground is dark."""
        self._is_dark = is_dark
        for listener in self._dark_listeners:
            listener(is_dark)

    def on_dark(self, listener: Callable[[bool], None]) -> None:
        """Call ``listener`` now, and as the page's ground becomes dark or light."""
        self._dark_listeners.append(listener)
        listener(self._is_dark)

    def on_text(self, uuid: str, reader: TextReader) -> None:
        """Give ``reader`` the texts that a control of that identity gets in place of numbers, as long as it lives."""
        self._readers[uuid] = reader

    def take_text(self, uuid: str, text: str) -> bool:
        """Hand on a text that came in place of a number; whether it has a reader."""
        reader = self._readers.get(uuid)
        if reader is not None:
            self.post(lambda: reader.read_text(text))
        return reader is not None

    def later(self, key: str, act: Callable[[], None], seconds: float = 0.0) -> None:
        """Run ``act`` in the page's thread; one that waits under the same key is replaced.

        A slider that is dragged sends more values than can be drawn: only its last one counts.

        Args:
            key: what ``act`` is about.
            act: what to do.
            seconds: time to wait first; it begins anew with each call.
        """
        with self._lock:
            waiting = self._timers.pop(key, None)
            if waiting is not None:
                waiting.cancel()
            if seconds > 0.0 and not self.is_closed:
                timer = threading.Timer(seconds, self._fire, (key, act))
                timer.daemon = True
                self._timers[key] = timer
                timer.start()
        if seconds <= 0.0:
            self._queue.put(key, act)

    def take(self, key: str, act: Callable[[], None], seconds: float = 0.0) -> None:
        """Run ``act``, which takes what a person gave, as `later` does; an error of it is a refusal.

        An error of what was under way is shown instead of the last one under the same key, until ``act`` succeeds.
        """
        self.later(key, lambda: self._try_taking(key, act), seconds)

    def post_taken(self, key: str, act: Callable[[], None]) -> None:
        """Run ``act`` as `take` does at once, but replace no earlier one of the key: none is left out."""
        self.post(lambda: self._try_taking(key, act))

    def _try_taking(self, key: str, act: Callable[[], None]) -> None:
        try:
            act()
        except SERIOUS as error:
            self.notice(str(error), topic=key)
        except SpiralTrunkError as error:
            self.notice(str(error), "refusal")
        else:
            self.clear_error(key)

    def _fire(self, key: str, act: Callable[[], None]) -> None:
        """Hand on an act whose time has come, where none has replaced it; its timer, which calls this, is forgotten."""
        with self._lock:
            if self._timers.get(key) is not threading.current_thread():
                return
            del self._timers[key]
        self._queue.put(key, act)

    def notice(self, text: str, kind: Kind = "error", title: str | None = None, *, topic: str = "") -> None:
        """Show a message: an error until it is closed, others for some seconds.

        It replaces the last one of its kind, an error the last one of its topic. At most `MOST_ERRORS` are shown.

        Args:
            text: the message.
            kind: its kind.
            title: its title, where it is not that of its kind.
            topic: what an error is about, for `clear_error`.
        """
        if self.is_closed:
            return
        name = f"error {topic}" if kind == "error" else kind
        self._remove_notice(name)
        seconds = None if kind == "error" else _SHOWN
        shown = self.client.add_notification(
            title or _TITLES[kind], text, color=_COLORS[kind], auto_close_seconds=seconds
        )
        with self._lock:
            self._notices[name] = shown
            errors = [each for each in self._notices if each.startswith("error ")]
        for oldest in errors[:-MOST_ERRORS]:
            self._remove_notice(oldest)

    def tell_failure(self, reason: str, topic: str = "") -> None:
        """Tell why work of `start` failed: as a refusal where it refused what it was given."""
        self.notice(reason, "refusal" if isinstance(reason, Refusal) else "error", topic=topic)

    def clear_refusal(self) -> None:
        """Remove the last refusal: what was given since has been taken."""
        self._remove_notice("refusal")

    def clear_error(self, topic: str) -> None:
        """Remove the error of a topic: what it was about has succeeded since."""
        self._remove_notice(f"error {topic}")

    def _remove_notice(self, name: str) -> None:
        with self._lock:
            last = self._notices.pop(name, None)
        if last is not None:
            last.remove()

    def start(
        self, work: Work, *arguments: Any, on_report: Callable[[Any], None], on_end: Callable[[Any, str | None], None]
    ) -> Job:
        """Start long work in a process of its own.

        Args:
            work: function of a module, called as ``work(report, *arguments)``; what it gives ``report`` arrives at
                ``on_report``.
            arguments: values that can be pickled.
            on_report: called in the page's thread with each report, none left out.
            on_end: called in the page's thread with the result, or with None and the reason where it failed or was
                stopped.
        """
        job = Job(work, arguments)
        self._jobs.add(job)

        def end(result: Any, reason: str | None) -> None:
            self._jobs.discard(job)
            self.post(lambda: on_end(result, reason))

        job.start(lambda report: self.post(lambda: on_report(report)), end)
        return job

    def post(self, act: Callable[[], None]) -> None:
        """Run ``act`` in the page's thread; none is left out."""
        self._queue.put(None, act)

    def on_close(self, act: Callable[[], None]) -> None:
        """Call ``act`` in the page's thread when the page is closed; the last registered first."""
        self._closing.append(act)

    def download(self, name: str, content: bytes) -> None:
        """Offer a file to the person."""
        self.client.send_file_download(name, content, save_immediately=True)

    def close(self) -> None:
        """Stop all that the page started; harmless when called again."""
        with self._lock:
            if self.is_closed:
                return
            self.is_closed = True
            for timer in self._timers.values():
                timer.cancel()
            self._timers.clear()
        for job in tuple(self._jobs):
            job.stop()
        self._queue.close(self._run_closing, _PATIENCE)

    def _run_closing(self) -> None:
        for act in reversed(self._closing):
            self.try_act(act)
        self._listeners.clear()
        self._dark_listeners.clear()

    def try_act(self, act: Callable[[], None]) -> None:
        """Run an act; its error becomes a notice on the page."""
        try:
            act()
        except (SpiralTrunkError, OSError) as error:
            self.notice(str(error))
        except Exception as error:
            if not self.is_closed:
                _log.exception("an act of the page failed")
                self.notice(f"{type(error).__name__}: {error}", title="An error in the studio")
