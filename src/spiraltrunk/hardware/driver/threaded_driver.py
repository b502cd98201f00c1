"""A driver whose loop runs in a thread of its own, by the computer's clock.

The thread keeps the loop and the watchdog's heartbeat going while a strategy plans or a screen is drawn; both then
share one interpreter with it. Python passes the interpreter on every 5 ms, two and a half periods of control, hence
`SWITCH_INTERVAL`. Compiled code that keeps the interpreter delays the loop all the same: `driver.lateness` tells.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import TypeVar, final

from numpy.typing import ArrayLike

from spiraltrunk.errors import RunError
from spiraltrunk.hardware.arm.arm_port import ArmPort, ArmState
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.driver.snapshot import Snapshot
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.safety.fault import Fault
from spiraltrunk.hardware.safety.states import Mode

SWITCH_INTERVAL = 0.0005
"""Time after which Python passes the interpreter on while a loop runs [s] (ours): a quarter of a period of control."""

_POLL = 0.002
"""Time that `ThreadedDriver.wait` sleeps [s]: one period at 500 Hz."""

_T = TypeVar("_T")


@final
class ThreadedDriver:
    """`TrunkDriver` with its loop in a thread; every call is safe from another thread.

    `wait` sleeps for one period and `tick` only tells of an error that ended the thread, so that whoever runs a driver
    runs this one, too. After such an error nothing is sent any more, and the watchdog ends the torque.
    """

    def __init__(self, driver: TrunkDriver) -> None:
        """Start the loop."""
        self.lock = threading.RLock()
        """Held while the loop advances."""
        self._driver = driver
        self._stopping = threading.Event()
        self._error: BaseException | None = None
        self._interval = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_INTERVAL, self._interval))
        self._thread = threading.Thread(target=self._run, name="driver", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._driver.wait()
                with self.lock:
                    self._driver.tick()
        except BaseException as error:  # Told by `tick`.
            self._error = error

    def _locked(self, call: Callable[[], _T]) -> _T:
        with self.lock:
            return call()

    @property
    def clock(self) -> Clock:
        """See `TrunkDriver.clock`."""
        return self._driver.clock

    @property
    def mode(self) -> Mode:
        """See `TrunkDriver.mode`."""
        return self._driver.mode

    @property
    def is_homed(self) -> bool:
        """See `TrunkDriver.is_homed`."""
        return self._driver.is_homed

    @property
    def faults(self) -> tuple[Fault, ...]:
        """See `TrunkDriver.faults`."""
        return self._driver.faults

    def home(self) -> None:
        """See `TrunkDriver.home`."""
        self._locked(self._driver.home)

    def arm(self) -> None:
        """See `TrunkDriver.arm`."""
        self._locked(self._driver.arm)

    def set_targets(
        self,
        tension: ArrayLike,
        pull: ArrayLike | None = None,
        *,
        arm_position: ArrayLike | None = None,
        gripper: ArrayLike = 0.0,
        valid_for: ArrayLike = 0.0,
    ) -> None:
        """See `TrunkDriver.set_targets`."""
        with self.lock:
            self._driver.set_targets(tension, pull, arm_position=arm_position, gripper=gripper, valid_for=valid_for)

    def disarm(self) -> None:
        """See `TrunkDriver.disarm`."""
        self._locked(self._driver.disarm)

    def stop(self) -> None:
        """See `TrunkDriver.stop`."""
        self._locked(self._driver.stop)

    def clear_fault(self, person: str) -> None:
        """See `TrunkDriver.clear_fault`."""
        self._locked(lambda: self._driver.clear_fault(person))

    def snapshot(self) -> Snapshot:
        """See `TrunkDriver.snapshot`; the loop does not wait while the lateness is summarised."""
        lateness = self._driver.summarise_lateness()
        return self._locked(lambda: self._driver.snapshot(lateness))

    def wait(self) -> None:
        """Sleep for one period; the thread runs meanwhile."""
        self.clock.sleep_until(self.clock.now() + _POLL)

    def tick(self) -> None:
        """Tell of an error that ended the thread.

        Raises:
            RunError: where there was one: the run is over, whatever was given.
        """
        if self._error is not None:
            raise RunError(f"the driver's loop ended: {self._error}") from self._error

    def close(self) -> None:
        """End the thread, let go, and release arm, servo and motors; harmless when called again."""
        self._stopping.set()
        self._thread.join()
        sys.setswitchinterval(self._interval)
        self._driver.close()


@final
class SharedArm:
    """An arm whose state may be read beside the loop of a `ThreadedDriver`."""

    def __init__(self, arm: ArmPort, driver: ThreadedDriver) -> None:
        self._arm, self._driver = arm, driver

    def read(self) -> ArmState:
        """See `ArmPort.read`."""
        with self._driver.lock:
            return self._arm.read()


Driver = TrunkDriver | ThreadedDriver
"""A driver, whoever runs its loop."""
