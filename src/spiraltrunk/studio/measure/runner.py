"""One piece of long work at a time, with its progress and a button that stops it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

from spiraltrunk.studio.measure import texts
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.job import STOPPED, Job
from spiraltrunk.studio.page.page import Page

TOPIC = "measure"
"""Topic of the tab's errors, which the next work that succeeds removes."""


@final
class Runner:
    """Long work of the tab."""

    def __init__(self, page: Page) -> None:
        """Add status, progress and stop button where the page's container is open."""
        self._page = page
        self._status: Any = page.gui.add_html(texts.EMPTY)
        self._bar: Any = page.gui.add_progress_bar(0.0, visible=False)
        self._stop: Any = add_button(
            page, "Stop", self.stop, hint="Stop the work that runs", visible=False, color="orange"
        )
        self._job: Job | None = None
        self._work: Callable[..., Any] | None = None
        self.on_idle: Callable[[], None] = lambda: None
        """Called when work has ended by itself."""

    def is_running(self, work: Callable[..., Any]) -> bool:
        """Whether this work runs."""
        return self.is_busy and self._work is work

    @property
    def is_busy(self) -> bool:
        """Whether work runs."""
        return self._job is not None

    def say(self, content: str) -> None:
        """Show HTML as the status; empty for none."""
        self._status.content = content
        self._status.visible = bool(content)

    def start(
        self, work: Callable[..., Any], *arguments: Any, done: Callable[[Any], None], failed: Callable[[str], None]
    ) -> None:
        """Start work instead of what runs.

        Args:
            work: function of a module, called with a report of (step, done, total) and the arguments.
            arguments: values that can be pickled.
            done: called with its result.
            failed: called with the reason where it failed.
        """
        self.stop()
        self.say(texts.format_working("starting"))
        self._bar.value, self._bar.visible, self._stop.visible = 0.0, True, True

        def end(result: Any, reason: str | None) -> None:
            if self._job is not job:  # Other work was started meanwhile.
                return
            self._finish()
            if reason is None:
                self._page.clear_error(TOPIC)
                self.say("")
                done(result)
            elif reason != STOPPED:
                self.say(texts.format_failed(reason))
                failed(reason)
            self.on_idle()

        def tell(report: tuple[str, int, int]) -> None:
            if self._job is job:
                step, count, total = report
                self.say(texts.format_working(step))
                self._bar.value = 100.0 * count / total if total > 0 else 0.0

        job = self._page.start(work, *arguments, on_report=tell, on_end=end)
        self._job, self._work = job, work

    def stop(self) -> None:
        """Stop what runs."""
        if self._job is not None:
            self._job.stop()
            self._finish()
            self.say(texts.STOPPED)

    def _finish(self) -> None:
        self._job = None
        self._bar.visible = self._stop.visible = False
