"""Poses of the cables: moved to, and saved under a name; the file is that of ``spiraltrunk drive pose``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, final

from spiraltrunk.design import TrunkDesign
from spiraltrunk.errors import DriveError, StudioError
from spiraltrunk.hardware.setup.poses import NAME_MAX, Pose, find_pose, load_poses, save_pose
from spiraltrunk.studio.page.buttons import add_button
from spiraltrunk.studio.page.controls import Choice, TextBox
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.drive.gamepad_jog import compute_pull_limits
from spiraltrunk.workflows.drive.remote.requests import Move, Request

_NONE = "none saved yet"


@final
class PoseControls:
    """List of the poses, and the name of a new one."""

    def __init__(
        self,
        page: Page,
        design: TrunkDesign,
        file: Path,
        ask: Callable[[Request], None],
        read_pulls: Callable[[], Sequence[float]],
    ) -> None:
        """Add them where the page's container is open.

        Args:
            page: the page.
            design: design of the robot.
            file: file of the poses.
            ask: sends a request.
            read_pulls: present pull of each cable [m]; raises where it is not known.
        """
        self._page, self._file, self._ask, self._read_pulls = page, file, ask, read_pulls
        self._limits = compute_pull_limits(design)
        with page.gui.add_folder("Poses", expand_by_default=False):
            hint = "Poses that were saved here, or by `spiraltrunk drive pose`"
            self._pose = Choice(page, "Pose", (_NONE,), _NONE, lambda _: None, hint=hint)
            hint = "Winds all cables to the lengths of the pose"
            self._move: Any = add_button(page, "Move to the pose", self._go, hint=hint)
            hint = f"Name of a pose to save, at most {NAME_MAX} characters"
            self._name = TextBox(page, "Name", "", lambda _: None, hint=hint, most=NAME_MAX)
            hint = f"Saves the present lengths of all cables in {file.name}; a pose of this name is replaced"
            add_button(page, "Save the pose", self._save, hint=hint)
        self._list()

    def _list(self, shown: str = "") -> None:
        """Show the names of the poses; a file that is no file of poses is reported, and left as it is."""
        try:
            names = tuple(sorted(load_poses(self._file, self._limits)))
        except DriveError as error:
            self._page.notice(str(error), "warning")
            names = ()
        self._pose.set_options(names or (_NONE,))
        self._pose.set(shown)
        self._move.disabled = not names

    def _go(self) -> None:
        self._ask(Move(tuple(find_pose(load_poses(self._file, self._limits), self._pose.value).pulls)))

    def _save(self) -> None:
        name = self._name.value.strip()
        if not name:
            raise StudioError("the pose has no name; write one above, then save it")
        save_pose(self._file, Pose(name, tuple(self._read_pulls())), self._limits)
        self._list(name)
        self._page.notice(f"the pose {name!r} is saved in {self._file.name}", "done")
